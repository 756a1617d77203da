#include "equaltime/film/film.h"

#include <string>

#include "equaltime/film/statistics.h"

namespace equaltime {

PixelMoments PixelMoments::merge(const PixelMoments& a, const PixelMoments& b) noexcept {
  if (a.count == 0) return b;
  if (b.count == 0) return a;
  PixelMoments m;
  m.count = a.count + b.count;
  const auto na = static_cast<double>(a.count), nb = static_cast<double>(b.count);
  const double n = na + nb;
  for (int c = 0; c < 3; ++c) {
    const double delta = b.mean[c] - a.mean[c];
    m.mean[c] = a.mean[c] + delta * (nb / n);
    m.deviation[c] = upper_half(std::sqrt((a.squares(c) + b.squares(c) + delta * delta * (na * nb / n)) / n));
  }
  return m;
}

std::array<double, 3> Film::mean(std::uint32_t x, std::uint32_t y) const {
  if (x >= width_ || y >= height_)
    throw std::out_of_range("pixel (" + std::to_string(x) + ", " + std::to_string(y) + ") is outside of a film of " +
                            std::to_string(width_) + " x " + std::to_string(height_) + " pixels");
  return std::to_array(join_replicates(&at(0, x, y), replicates_, std::size_t{width_} * height_).mean);
}

}  // namespace equaltime
