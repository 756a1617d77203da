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
[[nodiscard]] EQUALTIME_INLINE Point2f square_to_disk(Point2f u) noexcept {
  const float a = 2 * u.x - 1;
  const float b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const float r = select(wide, a, b);
  const auto [sine, cosine] = sin_cos_octant((kPi / 4) * (select(wide, b, a) / r));
  return {r * select(wide, cosine, sine), r * select(wide, sine, cosine)};
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

[[nodiscard]] EQUALTIME_INLINE Vec3f square_to_cosine_hemisphere(Point2f u) noexcept {
  const Point2f d = square_to_disk(u);
  return {d.x, d.y, safe_sqrt(1 - d.x * d.x - d.y * d.y)};
}
[[nodiscard]] constexpr float cosine_hemisphere_pdf(float cos_theta) noexcept {
  return cos_theta > 0 ? cos_theta * kInvPi : 0.0F;
}

[[nodiscard]] inline Vec3f square_to_uniform_sphere(Point2f u) noexcept {
  const float z = 1 - 2 * u.x;
  const float r = safe_sqrt(4 * u.x * (1 - u.x));
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
  return {r * cos_phi, r * sin_phi, z};
}
inline constexpr float kUniformSpherePdf = kInvPi / 4;

[[nodiscard]] inline Vec3f square_to_uniform_hemisphere(Point2f u) noexcept {
  const float r = safe_sqrt(u.x * (2 - u.x));
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
  return {r * cos_phi, r * sin_phi, 1 - u.x};
}
inline constexpr float kUniformHemispherePdf = kInvPi / 2;

/// Uniform direction of the cone round +z with 1 - cosθ_max = `one_minus_cos_max`, which keeps thin cones accurate.
[[nodiscard]] inline Vec3f square_to_uniform_cone(Point2f u, float one_minus_cos_max) noexcept {
  const float one_minus_cos = u.x * one_minus_cos_max;
  const float sin_theta = safe_sqrt(one_minus_cos * (2 - one_minus_cos));
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
  return {sin_theta * cos_phi, sin_theta * sin_phi, 1 - one_minus_cos};
}
[[nodiscard]] constexpr float uniform_cone_pdf(float one_minus_cos_max) noexcept {
  return 1 / (kTwoPi * one_minus_cos_max);
}

}  // namespace equaltime
