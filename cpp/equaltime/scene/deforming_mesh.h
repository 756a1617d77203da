// DeformingMesh: a mesh whose vertices and normals change linearly between evenly spaced times. Embree finds the
// triangle; DeformingMesh interpolates it at the ray's time, in float64.
#pragma once

#include <array>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/scene/recompute_hit.h"

namespace equaltime {

struct DeformingMesh {
  const TriangleMesh* mesh;          // the accel's own
  const MeshAttributes* attributes;  // normals and texture coordinates, if there are any

  /// The corners of a triangle at a time.
  [[nodiscard]] std::array<Vec3f, 3> corners(std::uint32_t primitive, float time) const noexcept {
    return corners_at(*mesh, primitive, time);
  }
  /// The normals of its vertices, of any length.
  [[nodiscard]] std::array<Vec3f, 3> normals_of(std::uint32_t primitive, float time) const noexcept;
  /// Derivative of the point by u on a triangle with these corners.
  [[nodiscard]] Vec3f tangent(std::uint32_t primitive, const std::array<Vec3f, 3>& corners) const noexcept;
  /// The plane of the corners at a time. Its offset bounds the distance to Embree's own interpolated corners.
  [[nodiscard]] TrianglePlane<float> plane(std::uint32_t primitive, float time) const noexcept;
};

/// Recomputes the hit of a ray on a triangle at a time. `mesh` views the same mesh at time 0.
template <Effects E>
[[nodiscard]] detail::SurfacePoint recompute_deforming_hit(const DeformingMesh& deforming, const MeshView& mesh,
                                                           const RayD& ray, std::uint32_t primitive,
                                                           float time) noexcept {
  const std::array<Vec3f, 3> corners = deforming.corners(primitive, time);
  const TrianglePlane<float> plane = deforming.plane(primitive, time);
  std::array<Vec3f, 3> normals;
  constexpr Triangle kItself = {0, 1, 2};
  MeshView now = mesh;
  now.triangles = &kItself, now.vertices = corners.data(), now.planes = &plane, now.tangents = nullptr;
  Vec3f tangent;
  if constexpr (E.anisotropy)
    if (mesh.tangents != nullptr) {
      tangent = deforming.tangent(primitive, corners);
      now.tangents = &tangent;
    }
  if (mesh.normals != nullptr) {
    normals = deforming.normals_of(primitive, time);
    now.normals = normals.data();
  }
  detail::SurfacePoint point = detail::recompute_hit<E>(now, ray, 0);
  point.primitive = primitive;
  return point;
}

}  // namespace equaltime
