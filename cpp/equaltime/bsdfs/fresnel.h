// Fresnel reflectance of unpolarised light at smooth interfaces.
#pragma once

#include <algorithm>
#include <cmath>

#include "equaltime/math/numeric.h"
#include "equaltime/math/spectrum.h"

namespace equaltime {

/// Reflectance of a conductor with complex index eta + i·k relative to the outside, for the cosine of incidence in [0,
/// 1]. Exact (Born & Wolf), in float64: indices from 1e-4 to 1e4 neither overflow nor cancel to less than float32
/// needs.
[[nodiscard]] inline float fresnel_conductor(float cos_theta, float eta, float k) noexcept {
  const double c = cos_theta, c2 = c * c, s2 = 1 - c2;
  const double e2 = static_cast<double>(eta) * eta, k2 = static_cast<double>(k) * k;
  const double t = e2 - k2 - s2;
  const double a2_b2 = std::sqrt(t * t + 4 * e2 * k2);
  const double a = std::sqrt(std::max(0.0, 0.5 * (a2_b2 + t)));
  const double perpendicular = (a2_b2 + c2 - 2 * a * c) / (a2_b2 + c2 + 2 * a * c);
  const double p = a2_b2 * c2 + s2 * s2, q = 2 * a * c * s2;
  const double parallel = p + q > 0 ? perpendicular * (p - q) / (p + q) : perpendicular;
  return static_cast<float>(0.5 * (perpendicular + parallel));
}
[[nodiscard]] inline Spectrum fresnel_conductor(float cos_theta, const Spectrum& eta, const Spectrum& k) noexcept {
  return {fresnel_conductor(cos_theta, eta.r, k.r), fresnel_conductor(cos_theta, eta.g, k.g),
          fresnel_conductor(cos_theta, eta.b, k.b)};
}

/// What a dielectric interface reflects of diffuse light, by fits as Mitsuba has them: Egan & Hilgeman 1973 from within
/// (eta < 1; to 0.1 % down to 1/1.5, to 0.6 % down to 1/2), d'Eon & Irving 2011 from outside (0.4 %). eta as below.
[[nodiscard]] inline float fresnel_diffuse(float eta) noexcept {
  const float x = 1 / eta;
  if (eta < 1) return 0.6681F + eta * (0.7099F - 1.4399F * eta) + 0.0636F * x;
  return 0.919317F + x * (-3.4793F + x * (6.75335F + x * (-7.80989F + x * (4.98554F - 1.36881F * x))));
}

/// A dielectric interface seen from one side: reflectance and the cosine of the refracted direction.
struct DielectricFresnel {
  float reflectance;
  float cos_transmitted;  // 0 under total internal reflection
};

/// `eta` is the index of the far side over that of the near side; cos_theta in [0, 1]. The differences in Fresnel's
/// amplitudes are formed from eta - 1, so that neither an index near 1 nor grazing incidence cancels digits.
[[nodiscard]] inline DielectricFresnel fresnel_dielectric(float cos_theta, float eta) noexcept {
  if (eta == 1) return {0.0F, cos_theta};
  const float eta2 = eta * eta, c2 = cos_theta * cos_theta;
  const float contrast = (eta - 1) * (eta + 1);
  const float across2 = contrast + c2;  // square of eta times the refracted cosine
  if (across2 <= 0) return {1.0F, 0.0F};
  const float across = std::sqrt(across2);
  const float s = contrast / square(cos_theta + across);
  const float p = contrast * ((eta2 + 1) * c2 - 1) / square(eta2 * cos_theta + across);
  return {0.5F * (s * s + p * p), across / eta};
}

}  // namespace equaltime
