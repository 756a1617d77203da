// Warps from the unit square to directions and disks. Directions are local, cosθ = z; pdfs are per solid angle.
#pragma once

#include "math/numeric.h"
#include "math/vector.h"
#include "sampling/sampler.h"

namespace equaltime {

/// Uniform point of the unit disk, concentric map (Shirley & Chiu 1997).
[[nodiscard]] EQUALTIME_INLINE Point2f square_to_disk(Point2f u) noexcept {
  const float a = 2 * u.x - 1;
  const float b = 2 * u.y - 1;
  if (a == 0 && b == 0) return {0, 0};
  const bool wide = std::abs(a) > std::abs(b);
  const float r = wide ? a : b;
  const auto [sine, cosine] = sin_cos_octant((kPi / 4) * ((wide ? b : a) / r));
  return {r * (wide ? cosine : sine), r * (wide ? sine : cosine)};
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
  const auto [sin_phi, cos_phi] = sin_cos(kTwoPi * u.y);
  return {r * cos_phi, r * sin_phi, z};
}
inline constexpr float kUniformSpherePdf = kInvPi / 4;

[[nodiscard]] inline Vec3f square_to_uniform_hemisphere(Point2f u) noexcept {
  const float r = safe_sqrt(u.x * (2 - u.x));
  const auto [sin_phi, cos_phi] = sin_cos(kTwoPi * u.y);
  return {r * cos_phi, r * sin_phi, 1 - u.x};
}
inline constexpr float kUniformHemispherePdf = kInvPi / 2;

/// Uniform direction of the cone round +z with 1 - cosθ_max = `one_minus_cos_max`, which keeps thin cones accurate.
[[nodiscard]] inline Vec3f square_to_uniform_cone(Point2f u, float one_minus_cos_max) noexcept {
  const float one_minus_cos = u.x * one_minus_cos_max;
  const float sin_theta = safe_sqrt(one_minus_cos * (2 - one_minus_cos));
  const auto [sin_phi, cos_phi] = sin_cos(kTwoPi * u.y);
  return {sin_theta * cos_phi, sin_theta * sin_phi, 1 - one_minus_cos};
}
[[nodiscard]] constexpr float uniform_cone_pdf(float one_minus_cos_max) noexcept {
  return 1 / (kTwoPi * one_minus_cos_max);
}

}  // namespace equaltime
