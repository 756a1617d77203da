// Tangents of triangles: how a point moves with its texture coordinates.
#pragma once

#include <array>

#include "equaltime/math/frame.h"
#include "equaltime/math/vector.h"

namespace equaltime {

using CornerUvs = std::array<std::array<double, 2>, 3>;
/// Of the corners of a triangle whose mesh has no uvs.
inline constexpr CornerUvs kBarycentric = {{{0, 0}, {1, 0}, {0, 1}}};
/// How the point moves with u on a triangle, of length 1; where uvs do not tell, as Frame makes it of the normal, as in
/// Mitsuba.
[[nodiscard]] inline Vec3f triangle_tangent(const std::array<Vec3f, 3>& corners, const CornerUvs& uvs) noexcept {
  const Vec3d e1 = Vec3d(corners[1]) - Vec3d(corners[0]), e2 = Vec3d(corners[2]) - Vec3d(corners[0]);
  const double u1 = uvs[1][0] - uvs[0][0], v1 = uvs[1][1] - uvs[0][1];
  const double u2 = uvs[2][0] - uvs[0][0], v2 = uvs[2][1] - uvs[0][1];
  const Vec3d tangent = (e1 * v2 - e2 * v1) * (u1 * v2 - u2 * v1);
  const double norm = length(tangent);
  return Vec3f(norm > 0 ? tangent / norm : FrameD::from_normal(normalize(cross(e1, e2))).s);
}

}  // namespace equaltime
