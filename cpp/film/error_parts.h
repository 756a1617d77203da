// The parts of which the estimated error of an image is made, and its standard errors. What they mean, and what is made
// of them, is told in python/equaltime/error_estimate.py; these are the passes over all pixels, by bands of rows on all
// cores. No result depends on how many cores there are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace equaltime {

/// Rows of pixels of three channels: their mean, the variance of that mean (NaN where unknown), and their samples.
struct PixelEstimates {
  const double *mean, *variance;
  const std::int64_t* samples;
  std::size_t height, width;
};

/// Sums over all pixels and channels.
struct ErrorSums {
  double slopes = 0;  ///< of -1/(2R) times the derivative of a contribution by its reference R
  double smooth = 0;  ///< of contributions that are noise, weighed by the share of the local mean in R
  double leant = 0;   ///< of how far a contribution moves as R leans
  /// Of products of the noise that reaches contributions by the local means around a pixel, and by the whole mean.
  double locals_squared = 0, crossed = 0, means_squared = 0;

  void add(const ErrorSums& other) noexcept;
};

/// Fills each pixel's part of error², (height, width). Every variance is known; `floor` is (0.1 m)².
[[nodiscard]] ErrorSums error_parts(const PixelEstimates& pixels, double floor, std::span<double> contributions);

/// Fills the standard errors, (height, width, 3): of the variance of one sample, averaged over the pixels of the 7x7
/// neighbourhood where it is known, and divided by the pixel's own samples. Infinite where the pixel's is unknown.
void standard_errors(const PixelEstimates& pixels, std::span<float> errors);

}  // namespace equaltime
