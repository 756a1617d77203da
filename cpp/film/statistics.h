// What is made of a film's moments: the replicates of a pixel joined, and sums over the 7x7 neighbourhoods of an image.
// Every sum has one order, which no thread changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "film/film.h"

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

/// The sum over the 7x7 neighbourhood of every pixel, zeros outside, of a row-major (height, width, channels) image.
/// Not by running sums: those lose a dark pixel beside a bright one, and spread what is not finite over the image.
void box_sum(std::span<const double> image, std::size_t height, std::size_t width, std::size_t channels,
             std::span<double> sums);

}  // namespace equaltime
