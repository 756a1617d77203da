// Winding numbers: whether a point is inside a closed mesh, from the solid angles of all its triangles (Van Oosterom &
// Strackee 1983), in float64. No ray is cast, so that neither edges nor thin walls can be missed.
#pragma once

#include <optional>

#include "accel/geometry.h"

namespace equaltime {

/// What a mesh is to a point.
struct Enclosure {
  bool behind;    // the point is on the side that the triangles' backs are on
  double volume;  // of the inside, not negative
};

/// At a time from 0 to 1, if the mesh deforms. Nothing if it is not closed.
[[nodiscard]] std::optional<Enclosure> enclosure(const TriangleMesh& mesh, const Vec3d& point, float time) noexcept;
[[nodiscard]] Enclosure enclosure(const SphereGeometry& sphere, bool flipped, const Vec3d& point) noexcept;

}  // namespace equaltime
