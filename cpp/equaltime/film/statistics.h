// What is made of a film's moments: the replicates of a pixel joined, and sums and means over neighbourhoods.
// Every sum has one order, which no thread changes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "equaltime/film/film.h"

namespace equaltime {

/// The mean of all samples of a pixel, the estimated variance *of that mean* (NaN from fewer than two replicates), and
/// how many samples there are.
struct JoinedPixel {
  double mean[3], variance[3];
  std::uint64_t samples;
};

/// `replicates` sets of moments, `stride` apart, of one pixel.
[[nodiscard]] JoinedPixel join_replicates(const PixelMoments* first, std::size_t replicates,
                                          std::size_t stride) noexcept;

/// The standard deviation of one sample in each channel, by the moments of all of them; 0 for fewer than two.
void sample_deviation(const PixelMoments* first, std::size_t replicates, std::size_t stride, double (&to)[3]) noexcept;

/// The sum over the 7x7 neighbourhood of every pixel, zeros outside, of a row-major (height, width, channels) image.
/// Not by running sums: those lose a dark pixel beside a bright one, and spread what is not finite over the image.
void box_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
             std::span<double> sums);

/// The sum over the 7x7 neighbourhood of every pixel without the pixel itself, zeros outside. The pixel's value does
/// not even change the rounding of the sum.
void others_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
                std::span<double> sums);

/// Sums over parts of the 7x7 neighbourhood of each pixel of one row, without the pixel itself; zeros outside. Its
/// value does not even change the rounding of the sums.
class PartSums {
 public:
  /// The halves of a neighbourhood, 4x7 pixels each: on one side of the pixel, with its own row or column.
  static constexpr std::size_t kHalves = 4;

  PartSums(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels);

  /// Goes to row `y`.
  void row(std::size_t y) noexcept;
  /// Sums over the halves above, below, left and right of value `i` of the row.
  [[nodiscard]] const std::array<double, kHalves>& halves(std::size_t i) const noexcept { return halves_[i]; }
  /// The sum over the eight pixels next to it.
  [[nodiscard]] double next(std::size_t i) const noexcept { return next_[i]; }

 private:
  std::span<const double> image_;
  std::size_t height_, channels_, length_;
  std::vector<double> outside_;                     ///< a row of zeros
  std::vector<double> above_, below_, own_, near_;  ///< sums of columns, with a margin of zeros at both ends
  std::vector<std::array<double, kHalves>> halves_;
  std::vector<double> next_;
};

/// The mean over the 5x5 around every pixel without the pixel itself, of which not a bit depends on it; the nearer ones
/// count by more, by a Gaussian of 0.8 pixels. What lies outside the image has no part in it; 0 for a single pixel.
void nearest_mean(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
                  std::span<double> means);

}  // namespace equaltime
