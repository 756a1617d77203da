// Slivers: triangles thinner than the rounding of their corners, or not much thicker. Embree's robust test finds some
// that a ray does not come near, because its edge functions round to 0 along the line of the longest edge. Meshes that
// have any get a filter, which compares such hits with the triangle in float64; others pay nothing.
#pragma once

#include <vector>

#include "equaltime/accel/embree.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

/// A mesh that stays as it is, and which of its triangles rays may seem to meet where they are not.
struct Slivers {
  const TriangleMesh* mesh;
  std::vector<bool> thin;  // one a triangle, or none if none is
};
[[nodiscard]] Slivers slivers_of(const TriangleMesh& mesh);

/// Lets Embree drop hits of a geometry's slivers that the ray passes by more than rounding. They outlive the geometry
/// as its user data.
void drop_false_hits(RTCGeometry geometry, Slivers& slivers) noexcept;

}  // namespace equaltime
