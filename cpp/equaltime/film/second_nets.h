// SecondNets: in a random pixel of every few, a second net of samples, which is not in the image. Where each pixel has
// one net, its halves are correlated, and their difference says its variance but for a factor. Two nets of one pixel
// are independent: their difference tells that factor (python/equaltime/film/second_nets.py).
#pragma once

#include <bit>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "equaltime/base/bits.h"
#include "equaltime/film/film.h"

namespace equaltime {

/// Added to the index of a sample of the second net.
inline constexpr std::uint64_t kSecondNet = std::uint64_t{1} << 32U;

class SecondNets {
 public:
  static constexpr std::uint32_t kMostPixels = 32;

  SecondNets() = default;
  /// Divides the film into rectangles of `pixels` pixels, a power of two up to `kMostPixels`. The seed draws one pixel
  /// of each, which has a second net. A rectangle at the border has none if the pixel lies outside of the film.
  SecondNets(std::uint64_t seed, std::uint32_t width, std::uint32_t height, std::uint32_t pixels)
      : seed_(seed),
        width_(width),
        height_(height),
        log2_wide_((static_cast<std::uint32_t>(std::bit_width(pixels))) / 2),
        log2_high_((static_cast<std::uint32_t>(std::bit_width(pixels)) - 1) / 2),
        film_(count(width, log2_wide_), count(height, log2_high_), 2, Sharing::halves) {
    if (!std::has_single_bit(pixels) || pixels > kMostPixels)
      throw std::invalid_argument("the pixels for one second net are a power of two up to 32");
  }

  [[nodiscard]] Film& film() noexcept { return film_; }
  [[nodiscard]] const Film& film() const noexcept { return film_; }

  /// Whether the pixel has a second net.
  [[nodiscard]] bool has(std::uint32_t x, std::uint32_t y) const noexcept {
    if (film_.width() == 0) return false;
    const Place drawn = drawn_in(x >> log2_wide_, y >> log2_high_);
    return drawn.x == x && drawn.y == y;
  }
  /// The moments of a pixel that has one.
  [[nodiscard]] PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) noexcept {
    return film_.at(replicate, x >> log2_wide_, y >> log2_high_);
  }
  void add(std::uint32_t x, std::uint32_t y, std::uint64_t i, const Spectrum& s, double scale) noexcept {
    film_.add(x >> log2_wide_, y >> log2_high_, i, s, scale);
  }
  [[nodiscard]] const PixelMoments& at(std::uint32_t replicate, std::uint32_t x, std::uint32_t y) const noexcept {
    return film_.at(replicate, x >> log2_wide_, y >> log2_high_);
  }

  /// The pixel, y * width + x, of each place of the film of second nets, row-major; -1 where none has one.
  [[nodiscard]] std::vector<std::int64_t> pixels() const {
    std::vector<std::int64_t> found;
    found.reserve(std::size_t{film_.width()} * film_.height());
    for (std::uint32_t v = 0; v < film_.height(); ++v)
      for (std::uint32_t u = 0; u < film_.width(); ++u) {
        const auto [x, y] = drawn_in(u, v);
        found.push_back(x < width_ && y < height_ ? std::int64_t{y} * width_ + x : -1);
      }
    return found;
  }

 private:
  struct Place {
    std::uint32_t x, y;
  };
  [[nodiscard]] static std::uint32_t count(std::uint32_t length, std::uint32_t log2_side) noexcept {
    return (length + (1U << log2_side) - 1) >> log2_side;
  }
  /// The pixel that is drawn in a rectangle, which may lie outside of the film.
  [[nodiscard]] Place drawn_in(std::uint32_t u, std::uint32_t v) const noexcept {
    const std::uint64_t random = mix64(mix64(seed_ + kNumbers) + (std::uint64_t{v} << 32U) + u);
    const auto low = static_cast<std::uint32_t>(random), high = static_cast<std::uint32_t>(random >> 32U);
    return {(u << log2_wide_) + (low & ((1U << log2_wide_) - 1)),
            (v << log2_high_) + (high & ((1U << log2_high_) - 1))};
  }

  static constexpr std::uint64_t kNumbers = 0x5ec07d0e75;  // the pixels are drawn with other numbers than samples

  std::uint64_t seed_ = 0;
  std::uint32_t width_ = 0, height_ = 0, log2_wide_ = 0, log2_high_ = 0;
  Film film_{0, 0, 0};
};

}  // namespace equaltime
