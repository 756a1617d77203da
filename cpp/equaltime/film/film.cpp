#include "equaltime/film/film.h"

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

}  // namespace equaltime
