// Film: running moments of every pixel's samples, means in float64, one set a replicate. A sample touches one pixel and
// samples arrive in ascending order, so sums do not depend on threads, tiles or passes. Threads may add to different
// pixels at the same time. Reading a pixel while a thread adds to it is a data race.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "equaltime/math/spectrum.h"

namespace equaltime {

/// The upper half of a float64 that is not negative, rounded: its whole range, with 21 significant bits.
[[nodiscard]] inline std::uint32_t upper_half(double value) noexcept {
  return static_cast<std::uint32_t>((std::bit_cast<std::uint64_t>(value) + 0x8000'0000U) >> 32U);
}
[[nodiscard]] inline double from_upper_half(std::uint32_t half) noexcept {
  return std::bit_cast<double>(std::uint64_t{half} << 32U);
}

/// Mean, count and standard deviation of a pixel's samples by Welford's recurrence: stable for any offset and number of
/// samples. The deviation is a root mean square (over n, not n - 1), so that rounding does not add up: each step
/// forgets a share 1/n of all before it, and after some million samples the value stays as it is.
struct PixelMoments {
  double mean[3] = {0, 0, 0};
  std::uint32_t count = 0;
  std::uint32_t deviation[3] = {0, 0, 0};  // upper halves

  /// `scale` takes the sample back to the user's units; exact when it is a power of two.
  void add(const Spectrum& s, double scale) noexcept {
    ++count;
    const double inv = 1.0 / static_cast<double>(count);
    const double value[3] = {static_cast<double>(s.r) * scale, static_cast<double>(s.g) * scale,
                             static_cast<double>(s.b) * scale};
    for (int c = 0; c < 3; ++c) {
      const double delta = value[c] - mean[c], before = from_upper_half(deviation[c]);
      mean[c] += delta * inv;
      const double square = before * before;
      deviation[c] = upper_half(std::sqrt(square + (delta * (value[c] - mean[c]) - square) * inv));
    }
  }

  /// Sum of squared deviations from the mean.
  [[nodiscard]] double squares(int c) const noexcept {
    const double one = from_upper_half(deviation[c]);
    return static_cast<double>(count) * (one * one);
  }

  /// Moments of the union of two disjoint sets of samples (Chan, Golub & LeVeque 1983).
  [[nodiscard]] static PixelMoments merge(const PixelMoments& a, const PixelMoments& b) noexcept;
};

/// How the samples of a pixel are shared out to its replicates. `alternate`: sample i belongs to replicate i mod R.
/// `halves`, for two: the first holds the largest power of two of samples that is less than all of them, the second
/// those after it. In a net whose first 2^k points are always a net again, both halves are nets as even as can be.
enum class Sharing : std::uint8_t { alternate, halves };

class Film {
 public:
  Film(std::uint32_t width, std::uint32_t height, std::uint32_t replicates, Sharing sharing = Sharing::alternate)
      : width_(width),
        height_(height),
        replicates_(replicates),
        sharing_(sharing),
        moments_(std::size_t{width} * height * replicates) {
    if (sharing == Sharing::halves && replicates != 2) throw std::invalid_argument("halves are two replicates");
  }

  [[nodiscard]] std::uint32_t width() const noexcept { return width_; }
  [[nodiscard]] std::uint32_t height() const noexcept { return height_; }
  [[nodiscard]] std::uint32_t replicates() const noexcept { return replicates_; }
  [[nodiscard]] PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) noexcept {
    return moments_[(std::size_t{replicate} * height_ + y) * width_ + x];
  }
  [[nodiscard]] const PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) const noexcept {
    return moments_[(std::size_t{replicate} * height_ + y) * width_ + x];
  }
  /// The estimate of a pixel: the mean of its samples in all replicates, as linear red, green and blue, in the units of
  /// the scene's radiances. All three are 0 for a pixel without samples. Throws std::out_of_range outside of the film.
  [[nodiscard]] std::array<double, 3> mean(std::uint32_t x, std::uint32_t y) const;
  /// Adds sample `i` of a pixel, after all before it; `scale` as in PixelMoments.
  void add(std::uint32_t x, std::uint32_t y, std::uint64_t i, const Spectrum& s, double scale) noexcept {
    if (sharing_ == Sharing::alternate) return at(static_cast<std::uint32_t>(i % replicates_), x, y).add(s, scale);
    if (i > 1 && std::has_single_bit(i)) join_halves(x, y);
    at(i > 0, x, y).add(s, scale);
  }
  /// How many of the first `samples` of a pixel belong to a replicate.
  [[nodiscard]] std::uint64_t count_of(std::uint32_t replicate, std::uint64_t samples) const noexcept {
    if (sharing_ == Sharing::alternate) return (samples + replicates_ - 1 - replicate) / replicates_;
    const std::uint64_t first = samples > 1 ? std::bit_floor(samples - 1) : samples;
    return replicate == 0 ? first : samples - first;
  }

  /// Row-major (replicate, y, x).
  [[nodiscard]] std::vector<PixelMoments>& moments() noexcept { return moments_; }

 private:
  void join_halves(std::uint32_t x, std::uint32_t y) noexcept {
    at(0, x, y) = PixelMoments::merge(at(0, x, y), at(1, x, y));
    at(1, x, y) = {};
  }

  std::uint32_t width_, height_, replicates_;
  Sharing sharing_;
  std::vector<PixelMoments> moments_;
};

}  // namespace equaltime
