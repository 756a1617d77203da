// The parts of which the estimated error of an image is made, and its standard errors. What they mean, and what is made
// of them, is told in python/equaltime/film/error.py; these are the passes over all pixels, by bands of rows on all
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
  const double* least = nullptr;  ///< light that each pixel's mean surely has, or null: no reference is below it
};

/// Sums over all pixels and channels.
struct ErrorSums {
  double slopes = 0;  ///< of minus the derivatives, by `floor`, of each channel's share of error²
  /// Of products of the noise that reaches contributions by the local means around a pixel, and by the whole mean.
  double locals_squared = 0, crossed = 0, means_squared = 0;

  void add(const ErrorSums& other) noexcept;
};

/// Each pixel's part of error², (height, width), by three references.
struct ErrorContributions {
  std::span<double> value;     ///< by the geometric mean of a denominator with the pixel and one without it
  std::span<double> lenient;   ///< by a reference that the pixel itself has a part in, and may make too bright
  std::span<double> cautious;  ///< by one that leaves the pixel out, and leans to the darker of its replicates
};

/// Fills the contributions. Every variance is known; `floor` is (0.1 m)².
[[nodiscard]] ErrorSums error_parts(const PixelEstimates& pixels, double floor,
                                    const ErrorContributions& contributions);

/// Fills the standard errors, (height, width, 3): of the variance of one sample, averaged over the pixels of the 7x7
/// neighbourhood where it is known, and divided by the pixel's own samples. Infinite where the pixel's is unknown.
void standard_errors(const PixelEstimates& pixels, std::span<float> errors);

}  // namespace equaltime
