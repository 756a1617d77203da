// Bands: rows of an image with the rows around them that neighbourhoods reach, worked on by all cores. What a band
// gives does not depend on how many cores there are.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "equaltime/analysis/error_parts.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/film/statistics.h"

namespace equaltime {

inline constexpr std::size_t kNeighbourRadius = 3, kChannels = 3;
inline constexpr std::size_t kBandRows = 64;  // few enough for the cache, with the rows around

using Doubles = std::vector<double>;

/// How many pixels of a line lie within the radius before one, and behind it.
struct Beside {
  std::size_t before, behind;

  Beside(std::size_t at, std::size_t length) noexcept
      : before(std::min(at, kNeighbourRadius)), behind(std::min(length - 1 - at, kNeighbourRadius)) {}

  [[nodiscard]] std::size_t all() const noexcept { return before + 1 + behind; }
  [[nodiscard]] std::size_t next() const noexcept {
    return std::min<std::size_t>(before, 1) + 1 + std::min<std::size_t>(behind, 1);
  }
};

/// The pixels of a neighbourhood that lie in the image.
struct Neighbourhood {
  Beside rows, columns;

  /// One over their number.
  [[nodiscard]] double share() const noexcept { return 1.0 / static_cast<double>(rows.all() * columns.all()); }
  /// How many there are in each half, and next to the pixel, without the pixel itself.
  [[nodiscard]] std::array<double, PartSums::kHalves> halves() const noexcept {
    const auto others = [](std::size_t across, std::size_t all) { return static_cast<double>((across + 1) * all - 1); };
    return {others(rows.before, columns.all()), others(rows.behind, columns.all()), others(columns.before, rows.all()),
            others(columns.behind, rows.all())};
  }
  [[nodiscard]] double next() const noexcept { return static_cast<double>(rows.next() * columns.next() - 1); }
};

/// Rows `begin` to `end` of the image, and the rows `halo` around them, of which `pixels` is made.
struct Band {
  PixelEstimates pixels;
  std::size_t begin, end, first, image_height;

  Band(const PixelEstimates& image, std::size_t begin_row, std::size_t halo)
      : begin(begin_row),
        end(std::min(begin_row + kBandRows, image.height)),
        first(begin_row < halo ? 0 : begin_row - halo),
        image_height(image.height) {
    const std::size_t skipped = first * image.width;
    pixels = {image.mean + kChannels * skipped,
              image.variance + kChannels * skipped,
              image.samples + skipped,
              std::min(end + halo, image.height) - first,
              image.width,
              image.least == nullptr ? nullptr : image.least + kChannels * skipped};
  }

  [[nodiscard]] std::size_t size() const noexcept { return kChannels * pixels.height * pixels.width; }
  void box_sum(const double* values, Doubles& sums) const {
    equaltime::box_sum({values, size()}, pixels.height, pixels.width, kChannels, sums);
  }
  void others_sum(const double* values, Doubles& sums) const {
    equaltime::others_sum({values, size()}, pixels.height, pixels.width, kChannels, sums);
  }
  [[nodiscard]] Neighbourhood around(std::size_t x, std::size_t y) const noexcept {
    return {Beside(first + y, image_height), Beside(x, pixels.width)};
  }
  /// Calls f(index, share) for each value of the rows [from, to) of `pixels`. `share` is one over the number of pixels
  /// in the neighbourhood of the value's pixel.
  template <class F>
  void each(std::size_t from, std::size_t to, const F& f) const {
    for (std::size_t y = from, i = kChannels * from * pixels.width; y < to; ++y)
      for (std::size_t x = 0; x < pixels.width; ++x) {
        const double share = around(x, y).share();
        for (std::size_t c = 0; c < kChannels; ++c, ++i) f(i, share);
      }
  }
  template <class F>
  void each_own(const F& f) const {
    each(begin - first, end - first, f);
  }
};

/// Calls work(band, number of the band, scratch) for all bands of an image. Each thread has one Scratch, which takes
/// its memory by fit(number of values of a band).
template <class Scratch, class Work>
void over_bands(const PixelEstimates& image, std::size_t halo, const Work& work) {
  const std::size_t bands = (image.height + kBandRows - 1) / kBandRows;
  const std::size_t threads = std::max<std::size_t>(std::min<std::size_t>(bands, thread_count(0)), 1);
  run_blocks(bands, static_cast<unsigned>(threads), [&] {
    return [&, scratch = Scratch()](std::size_t i) mutable {
      const Band band(image, i * kBandRows, halo);
      scratch.fit(band.size());
      work(band, i, scratch);
    };
  });
}

}  // namespace equaltime
