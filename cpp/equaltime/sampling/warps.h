// Warps from the unit square to directions and disks. Directions are local, cosθ = z; pdfs are per solid angle.
#pragma once

#include <algorithm>
#include <cstdint>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/vector.h"
#include "equaltime/sampling/sampler.h"

namespace equaltime {

/// Uniform point of the unit disk, concentric map (Shirley & Chiu 1997).
template <class Real>
[[nodiscard]] EQUALTIME_INLINE Point2<Real> square_to_disk(Point2<Real> u) noexcept {
  const Real a = 2 * u.x - 1, b = 2 * u.y - 1;
  const Mask<Real> off_center = a != 0 || b != 0;
  if (none(off_center)) return {0, 0};
  const Mask<Real> wide = abs(a) > abs(b);
  const Real r = select(wide, a, b);
  const auto [sine, cosine] = sin_cos_octant<Real>((kPi / 4) * (select(wide, b, a) / r));
  const Point2<Real> point{r * select(wide, cosine, sine), r * select(wide, sine, cosine)};
  return where(off_center, [&] { return point; });
}

/// Uniform point of the regular polygon of n corners on the unit circle, one of them at an angle, in radians; its area
/// is n/2·sin(2π/n). The first number picks a triangle from the centre to a side, and how far from the centre.
[[nodiscard]] inline Point2f square_to_polygon(Point2f u, std::uint32_t n, float angle) noexcept {
  const float place = u.x * static_cast<float>(n);
  const std::uint32_t side = std::min(static_cast<std::uint32_t>(place), n - 1);
  const float step = kTwoPi / static_cast<float>(n);
  const auto [s0, c0] = sin_cos(angle + step * static_cast<float>(side));
  const auto [s1, c1] = sin_cos(angle + step * static_cast<float>(side + 1));
  const float r = safe_sqrt(std::min(1.0F, place - static_cast<float>(side)));
  return {r * (c0 + (c1 - c0) * u.y), r * (s0 + (s1 - s0) * u.y)};
}

template <class Real>
[[nodiscard]] EQUALTIME_INLINE Vec3<Real> square_to_cosine_hemisphere(Point2<Real> u) noexcept {
  const Point2<Real> d = square_to_disk(u);
  return {d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)};
}
template <class Real>
[[nodiscard]] constexpr Real cosine_hemisphere_pdf(Real cos_theta) noexcept {
  return where(cos_theta > 0, [&] { return cos_theta * kInvPi; });
}

template <class Real>
[[nodiscard]] inline Vec3<Real> square_to_uniform_sphere(Point2<Real> u) noexcept {
  const Real z = 1 - 2 * u.x;
  const Real r = safe_sqrt(4 * u.x * (1 - u.x));
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
  return {r * cos_phi, r * sin_phi, z};
}
inline constexpr float kUniformSpherePdf = kInvPi / 4;

template <class Real>
[[nodiscard]] inline Vec3<Real> square_to_uniform_hemisphere(Point2<Real> u) noexcept {
  const Real r = safe_sqrt(u.x * (2 - u.x));
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
  return {r * cos_phi, r * sin_phi, 1 - u.x};
}
inline constexpr float kUniformHemispherePdf = kInvPi / 2;

}  // namespace equaltime
