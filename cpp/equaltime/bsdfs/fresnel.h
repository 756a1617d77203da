// Fresnel reflectance of unpolarised light at smooth interfaces.
#pragma once

#include "equaltime/math/numeric.h"
#include "equaltime/math/spectrum.h"

namespace equaltime {

/// Reflectance of a conductor with complex index eta + i·k relative to the outside, for the cosine of incidence in [0,
/// 1]. Exact (Born & Wolf), in float64: indices from 1e-4 to 1e4 neither overflow nor cancel to less than float32
/// needs.
template <class Real>
[[nodiscard]] inline Real fresnel_conductor(Real cos_theta, Real eta, Real k) noexcept {
  using Double = Double<Real>;
  const Double c(cos_theta), c2 = c * c, s2 = 1 - c2;
  const Double e(eta), e2 = e * e, k2 = square(Double(k));
  const Double t = e2 - k2 - s2;
  const Double a2_b2 = sqrt(t * t + 4 * e2 * k2);
  const Double a = sqrt(max(Double(0), 0.5 * (a2_b2 + t)));
  const Double perpendicular = (a2_b2 + c2 - 2 * a * c) / (a2_b2 + c2 + 2 * a * c);
  const Double p = a2_b2 * c2 + s2 * s2, q = 2 * a * c * s2;
  const Double parallel = where(
      p + q > 0, [&] { return perpendicular * (p - q) / (p + q); }, [&] { return perpendicular; });
  return Real(0.5 * (perpendicular + parallel));
}
template <class Real>
[[nodiscard]] inline Rgb<Real> fresnel_conductor(Real cos_theta, const Rgb<Real>& eta, const Rgb<Real>& k) noexcept {
  return {fresnel_conductor(cos_theta, eta.r, k.r), fresnel_conductor(cos_theta, eta.g, k.g),
          fresnel_conductor(cos_theta, eta.b, k.b)};
}

/// What a dielectric interface reflects of diffuse light, by fits as Mitsuba has them: Egan & Hilgeman 1973 from within
/// (eta < 1; to 0.1 % down to 1/1.5, to 0.6 % down to 1/2), d'Eon & Irving 2011 from outside (0.4 %). eta as below.
template <class Real>
[[nodiscard]] inline Real fresnel_diffuse(Real eta) noexcept {
  const Real x = 1 / eta;
  return where(
      eta < 1, [&] { return 0.6681F + eta * (0.7099F - 1.4399F * eta) + 0.0636F * x; },
      [&] { return 0.919317F + x * (-3.4793F + x * (6.75335F + x * (-7.80989F + x * (4.98554F - 1.36881F * x)))); });
}

/// The index of the far side over that of the near side; `ior`: interior over exterior, `front`: seen from outside.
template <class Real>
[[nodiscard]] inline Real relative_ior(Real ior, Mask<Real> front) noexcept {
  return where(
      front, [&] { return ior; }, [&] { return 1 / ior; });
}

/// A dielectric interface seen from one side: reflectance and the cosine of the refracted direction.
template <class Real>
struct DielectricFresnel {
  Real reflectance;
  Real cos_transmitted;  // 0 under total internal reflection
};

/// `eta` is the index of the far side over that of the near side; cos_theta in [0, 1]. The differences in Fresnel's
/// amplitudes are formed from eta - 1, so that neither an index near 1 nor grazing incidence cancels digits.
template <class Real>
[[nodiscard]] inline DielectricFresnel<Real> fresnel_dielectric(Real cos_theta, Real eta) noexcept {
  const Mask<Real> differs = eta != 1;
  if (none(differs)) return {0, cos_theta};
  const Real eta2 = eta * eta, c2 = cos_theta * cos_theta;
  const Real contrast = (eta - 1) * (eta + 1);
  const Real across2 = contrast + c2;  // square of eta times the refracted cosine
  const Mask<Real> passes = !(across2 <= 0);
  if (none(passes)) return {1, 0};
  const Real across = safe_sqrt(across2);
  const Real s = contrast / square(cos_theta + across);
  const Real p = contrast * ((eta2 + 1) * c2 - 1) / square(eta2 * cos_theta + across);
  return {select(passes, 0.5F * (s * s + p * p), Real(1)), select(differs, across / eta, cos_theta)};
}

}  // namespace equaltime
