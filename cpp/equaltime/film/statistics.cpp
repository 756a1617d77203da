#include "equaltime/film/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "equaltime/math/elementary.h"

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

void sample_deviation(const PixelMoments* first, std::size_t replicates, std::size_t stride, double (&to)[3]) noexcept {
  const JoinedPixel joined = join_replicates(first, replicates, stride);
  for (int c = 0; c < 3; ++c) {
    double squares = 0;
    for (std::size_t r = 0; r < replicates; ++r) {
      const PixelMoments& m = first[r * stride];
      const double apart = m.mean[c] - joined.mean[c];
      squares += m.squares(c) + static_cast<double>(m.count) * (apart * apart);
    }
    to[c] = std::sqrt(squares / std::max(static_cast<double>(joined.samples) - 1, 1.0));
  }
}

namespace {

/// Rows of an image around one; `outside` is the row of zeros that stands for those outside it.
class Rows {
 public:
  Rows(std::span<const double> image, std::size_t height, std::size_t length, std::span<const double> outside) noexcept
      : image_(image), outside_(outside), height_(height), length_(length) {}

  [[nodiscard]] const double* operator()(std::size_t y, std::ptrdiff_t step) const noexcept {
    const auto row = static_cast<std::ptrdiff_t>(y) + step;
    if (row < 0 || row >= static_cast<std::ptrdiff_t>(height_)) return outside_.data();
    return image_.data() + static_cast<std::size_t>(row) * length_;
  }

 private:
  std::span<const double> image_, outside_;
  std::size_t height_, length_;
};

double six(double a, double b, double c, double d, double e, double f) noexcept {
  return ((a + b) + (c + d)) + (e + f);
}

double seven(double a, double b, double c, double d, double e, double f, double g) noexcept {
  return six(a, b, c, d, e, f) + g;
}

constexpr std::size_t kRadius = 3;

}  // namespace

void box_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
             std::span<double> sums) {
  const std::size_t row = width * channels, margin = kRadius * channels;
  std::vector<double> padded(row + 2 * margin), outside(row);
  const Rows at(image, height, row, outside);
  for (std::size_t y = 0; y < height; ++y) {
    const double* const r[] = {at(y, -3), at(y, -2), at(y, -1), at(y, 0), at(y, 1), at(y, 2), at(y, 3)};
    for (std::size_t i = 0; i < row; ++i)
      padded[margin + i] = seven(r[0][i], r[1][i], r[2][i], r[3][i], r[4][i], r[5][i], r[6][i]);
    const double* p = padded.data();
    double* to = sums.data() + y * row;
    const std::size_t c = channels;
    for (std::size_t i = 0; i < row; ++i, ++p)
      to[i] = seven(p[0], p[c], p[2 * c], p[3 * c], p[4 * c], p[5 * c], p[6 * c]);
  }
}

void others_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
                std::span<double> sums) {
  const std::size_t row = width * channels, margin = kRadius * channels;
  std::vector<double> padded(row + 2 * margin), outside(row);
  const Rows at(image, height, row, outside);
  for (std::size_t y = 0; y < height; ++y) {
    const double* const r[] = {at(y, -3), at(y, -2), at(y, -1), at(y, 0), at(y, 1), at(y, 2), at(y, 3)};
    double* to = sums.data() + y * row;
    for (std::size_t i = 0; i < row; ++i) {
      to[i] = six(r[0][i], r[1][i], r[2][i], r[4][i], r[5][i], r[6][i]);
      padded[margin + i] = to[i] + r[3][i];
    }
    const double* p = padded.data();
    const std::size_t c = channels;
    for (std::size_t i = 0; i < row; ++i, ++p) to[i] += six(p[0], p[c], p[2 * c], p[4 * c], p[5 * c], p[6 * c]);
  }
}

PartSums::PartSums(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels)
    : image_(image),
      height_(height),
      channels_(channels),
      length_(width * channels),
      outside_(length_),
      halves_(length_),
      next_(length_) {
  for (std::vector<double>* columns : {&above_, &below_, &own_, &near_})
    columns->resize(length_ + 2 * kRadius * channels);
}

void PartSums::row(std::size_t y) noexcept {
  const std::size_t c = channels_, margin = kRadius * c;
  const Rows at(image_, height_, length_, outside_);
  const double* const r[] = {at(y, -3), at(y, -2), at(y, -1), at(y, 0), at(y, 1), at(y, 2), at(y, 3)};
  for (std::size_t i = 0; i < length_; ++i) {
    above_[margin + i] = (r[0][i] + r[1][i]) + r[2][i];
    below_[margin + i] = (r[6][i] + r[5][i]) + r[4][i];
    own_[margin + i] = r[3][i];
    near_[margin + i] = r[2][i] + r[4][i];
  }
  const auto left = [&](const double* p) { return (p[0] + p[c]) + p[2 * c]; };
  const auto right = [&](const double* p) { return (p[6 * c] + p[5 * c]) + p[4 * c]; };
  for (std::size_t i = 0; i < length_; ++i) {
    const double *above = &above_[i], *below = &below_[i], *own = &own_[i], *near = &near_[i];
    const double left_own = left(own), right_own = right(own), beside = left_own + right_own;
    halves_[i] = {((left(above) + right(above)) + above[3 * c]) + beside,
                  ((left(below) + right(below)) + below[3 * c]) + beside,
                  ((left(above) + left(below)) + (above[3 * c] + below[3 * c])) + left_own,
                  ((right(above) + right(below)) + (above[3 * c] + below[3 * c])) + right_own};
    next_[i] = ((near[2 * c] + near[4 * c]) + near[3 * c]) + (own[2 * c] + own[4 * c]);
  }
}

namespace {

/// The weighted sums of which `nearest_mean` is made.
void nearest_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
                 std::span<double> sums) {
  const double near = elementary::exp(-0.5 / 0.64), far = elementary::exp(-2 / 0.64);
  const auto weighted = [&](double a, double b, double c, double d) { return near * (b + c) + far * (a + d); };
  const std::size_t row = width * channels, margin = 2 * channels, c = channels;
  std::vector<double> padded(row + 2 * margin), across(image.size()), outside(row);
  for (std::size_t y = 0; y < height; ++y) {
    std::copy_n(image.data() + y * row, row, padded.data() + margin);
    const double* p = padded.data();
    double* to = sums.data() + y * row;
    for (std::size_t i = 0; i < row; ++i, ++p) to[i] = weighted(p[0], p[c], p[3 * c], p[4 * c]);
  }
  std::transform(image.begin(), image.end(), sums.begin(), across.begin(), std::plus<>());
  const Rows at(across, height, row, outside);
  for (std::size_t y = 0; y < height; ++y) {
    const double* const r[] = {at(y, -2), at(y, -1), at(y, 1), at(y, 2)};
    double* to = sums.data() + y * row;
    for (std::size_t i = 0; i < row; ++i) to[i] += weighted(r[0][i], r[1][i], r[2][i], r[3][i]);
  }
}

}  // namespace

void nearest_mean(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
                  std::span<double> means) {
  nearest_sum(image, height, width, channels, means);
  const std::vector<double> ones(height * width, 1.0);
  std::vector<double> weights(ones.size());
  nearest_sum(ones, height, width, 1, weights);
  for (std::size_t i = 0; i < weights.size(); ++i)
    for (std::size_t c = 0; c < channels; ++c)
      means[i * channels + c] /= std::max(weights[i], std::numeric_limits<double>::min());
}

}  // namespace equaltime
