#include "film/statistics.h"

#include <algorithm>
#include <limits>

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

/// Seven values, `stride` apart; the first four are two pairs.
double seven(const double* v, std::size_t stride) noexcept {
  return ((v[0] + v[stride]) + (v[2 * stride] + v[3 * stride])) + (v[4 * stride] + v[5 * stride]) + v[6 * stride];
}

}  // namespace

std::vector<double> box_sum(std::span<const double> image, std::size_t height, std::size_t width,
                            std::size_t channels) {
  constexpr std::size_t kRadius = 3;
  const std::size_t row = width * channels, margin = kRadius * channels;
  std::vector<double> sums(height * row), padded(row + 2 * margin), column(7 * row);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t k = 0; k < 7; ++k) {  // the rows around this one
      const auto to = column.begin() + static_cast<std::ptrdiff_t>(k * row);
      if (y + k < kRadius || y + k - kRadius >= height)
        std::fill_n(to, row, 0.0);
      else
        std::copy_n(image.begin() + static_cast<std::ptrdiff_t>((y + k - kRadius) * row), row, to);
    }
    for (std::size_t i = 0; i < row; ++i) padded[margin + i] = seven(&column[i], row);
    for (std::size_t i = 0; i < row; ++i) sums[y * row + i] = seven(&padded[i], channels);
  }
  return sums;
}

}  // namespace equaltime
