#include "equaltime/media/medium.h"

#include <cmath>
#include <limits>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// exp(-sigma·t); 1 where nothing is in the way, however far that is.
double transmittance_of(double sigma, double t) noexcept { return sigma > 0 ? elementary::exp(-sigma * t) : 1.0; }

/// Where there is no end, nothing is looked for beyond: 2^30 times the scene, from where no float32 tells its light
/// from none.
constexpr double kFarthest = 0x1p40;

struct Colors {
  explicit Colors(const Spectrum& s) noexcept
      : of{static_cast<double>(s.r), static_cast<double>(s.g), static_cast<double>(s.b)} {}
  double of[3];
};

/// The same for each colour. Most media are grey, so that equal exponentials are computed once.
void transmittance_of(const Colors& sigma, double t, double (&left)[3]) noexcept {
  left[0] = transmittance_of(sigma.of[0], t);
  left[1] = sigma.of[1] == sigma.of[0] ? left[0] : transmittance_of(sigma.of[1], t);
  left[2] = sigma.of[2] == sigma.of[1] ? left[1] : transmittance_of(sigma.of[2], t);
}

Spectrum quotients(const double (&numerators)[3], double denominator) noexcept {
  return {static_cast<float>(numerators[0] / denominator), static_cast<float>(numerators[1] / denominator),
          static_cast<float>(numerators[2] / denominator)};
}

}  // namespace

Spectrum Medium::transmittance(double t) const noexcept {
  const Colors sigma(sigma_t);
  double left[3];
  transmittance_of(sigma, t, left);
  return quotients(left, 1);
}

DistanceSample Medium::sample(const Spectrum& beta, double distance, Point2d u) const noexcept {
  if (sigma_s.is_black()) return {distance, false, transmittance(distance)};
  const Colors sigma(sigma_t), scattering(sigma_s), weight(beta);
  const double sum = weight.of[0] + weight.of[1] + weight.of[2];
  const double place = u.y * sum;
  int picked = 2;
  if (place < weight.of[0])
    picked = 0;
  else if (place < weight.of[0] + weight.of[1] || !(weight.of[2] > 0))
    picked = weight.of[1] > 0 ? 1 : 0;
  const double extinction = sigma.of[picked];
  const double drawn = extinction > 0 ? -elementary::log1p(-u.x) / extinction : std::numeric_limits<double>::infinity();
  const bool scattered = drawn < distance;
  const double t = scattered ? drawn : distance;
  if (scattered && t > kFarthest) return {0, true, {}};
  double left[3], values[3], density = 0;
  transmittance_of(sigma, t, left);
  for (int c = 0; c < 3; ++c) {
    density += weight.of[c] / sum * (scattered ? sigma.of[c] * left[c] : left[c]);
    values[c] = scattered ? scattering.of[c] * left[c] : left[c];
  }
  return {t, scattered, quotients(values, density)};
}

}  // namespace equaltime
