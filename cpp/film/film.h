// Film: running moments of every pixel's samples, in float64, one set a replicate (sample i belongs to replicate i mod
// R). A sample touches one pixel and samples arrive in ascending order, so sums do not depend on threads, tiles or
// passes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "math/spectrum.h"

namespace equaltime {

/// Count, mean and sum of squared deviations by Welford's recurrence: stable for any offset and number of samples.
struct PixelMoments {
  std::uint64_t count = 0;
  double mean[3] = {0, 0, 0};
  double m2[3] = {0, 0, 0};

  /// `scale` takes the sample back to the user's units; exact when it is a power of two.
  void add(const Spectrum& s, double scale) noexcept {
    ++count;
    const double inv = 1.0 / static_cast<double>(count);
    const double value[3] = {static_cast<double>(s.r) * scale, static_cast<double>(s.g) * scale,
                             static_cast<double>(s.b) * scale};
    for (int c = 0; c < 3; ++c) {
      const double delta = value[c] - mean[c];
      mean[c] += delta * inv;
      m2[c] += delta * (value[c] - mean[c]);
    }
  }

  /// Moments of the union of two disjoint sets of samples (Chan, Golub & LeVeque 1983).
  [[nodiscard]] static PixelMoments merge(const PixelMoments& a, const PixelMoments& b) noexcept;
};

class Film {
 public:
  Film(std::uint32_t width, std::uint32_t height, std::uint32_t replicates)
      : width_(width), height_(height), replicates_(replicates), moments_(std::size_t{width} * height * replicates) {}

  [[nodiscard]] std::uint32_t width() const noexcept { return width_; }
  [[nodiscard]] std::uint32_t height() const noexcept { return height_; }
  [[nodiscard]] std::uint32_t replicates() const noexcept { return replicates_; }
  [[nodiscard]] PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) noexcept {
    return moments_[(std::size_t{replicate} * height_ + y) * width_ + x];
  }
  [[nodiscard]] const PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) const noexcept {
    return moments_[(std::size_t{replicate} * height_ + y) * width_ + x];
  }
  /// Row-major (replicate, y, x).
  [[nodiscard]] std::vector<PixelMoments>& moments() noexcept { return moments_; }

 private:
  std::uint32_t width_, height_, replicates_;
  std::vector<PixelMoments> moments_;
};

}  // namespace equaltime
