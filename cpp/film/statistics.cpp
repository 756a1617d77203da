#include "film/statistics.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <vector>

namespace equaltime {

JoinedPixel join_replicates(const PixelMoments* first, std::size_t replicates, std::size_t stride) noexcept {
  JoinedPixel joined{};
  std::size_t seen = 0;
  for (std::size_t r = 0; r < replicates; ++r) {
    const PixelMoments& m = first[r * stride];
    joined.samples += m.count;
    seen += m.count > 0;
    for (int c = 0; c < 3; ++c) joined.mean[c] += static_cast<double>(m.count) * m.mean[c];
  }
  const double total = std::max(static_cast<double>(joined.samples), 1.0);
  for (double& mean : joined.mean) mean /= total;
  if (seen < 2) {
    std::fill_n(joined.variance, 3, std::numeric_limits<double>::quiet_NaN());
    return joined;
  }
  for (std::size_t r = 0; r < replicates; ++r) {
    const PixelMoments& m = first[r * stride];
    for (int c = 0; c < 3; ++c) {
      const double apart = m.mean[c] - joined.mean[c];
      joined.variance[c] += static_cast<double>(m.count) * (apart * apart);
    }
  }
  for (double& variance : joined.variance) variance /= static_cast<double>(seen - 1) * total;
  return joined;
}

namespace {

double seven(double a, double b, double c, double d, double e, double f, double g) noexcept {
  return ((a + b) + (c + d)) + (e + f) + g;
}

}  // namespace

void box_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
             std::span<double> sums) {
  constexpr std::size_t kRadius = 3;
  const std::size_t row = width * channels, margin = kRadius * channels;
  const std::vector<double> outside(row);
  std::vector<double> padded(row + 2 * margin);
  for (std::size_t y = 0; y < height; ++y) {
    const double* rows[2 * kRadius + 1];
    for (std::size_t k = 0; k < std::size(rows); ++k) {
      const bool inside = y + k >= kRadius && y + k - kRadius < height;
      rows[k] = inside ? image.data() + (y + k - kRadius) * row : outside.data();
    }
    for (std::size_t i = 0; i < row; ++i)
      padded[margin + i] = seven(rows[0][i], rows[1][i], rows[2][i], rows[3][i], rows[4][i], rows[5][i], rows[6][i]);
    const double* p = padded.data();
    double* to = sums.data() + y * row;
    const std::size_t c = channels;
    for (std::size_t i = 0; i < row; ++i, ++p)
      to[i] = seven(p[0], p[c], p[2 * c], p[3 * c], p[4 * c], p[5 * c], p[6 * c]);
  }
}

}  // namespace equaltime
