#include "equaltime/scene/deforming_mesh.h"

#include "equaltime/shapes/triangle_tangent.h"

namespace equaltime {

std::array<Vec3f, 3> DeformingMesh::normals_of(std::uint32_t primitive, float time) const noexcept {
  const auto [before, fraction] = between(time, mesh->later.size());
  const std::vector<Vec3f>& a = before == 0 ? attributes->normals : attributes->later_normals[before - 1];
  const std::vector<Vec3f>& b = attributes->later_normals[before];
  const auto& [i, j, k] = mesh->triangles[primitive];
  return {mixed(a[i], b[i], fraction), mixed(a[j], b[j], fraction), mixed(a[k], b[k], fraction)};
}

Vec3f DeformingMesh::tangent(std::uint32_t primitive, const std::array<Vec3f, 3>& corners) const noexcept {
  CornerUvs uvs = kBarycentric;
  const std::vector<Point2f>& given = attributes->uvs;
  for (std::size_t i = 0; !given.empty() && i < 3; ++i) {
    const Point2f& uv = given[mesh->triangles[primitive][i]];
    uvs[i] = {static_cast<double>(uv.x), static_cast<double>(uv.y)};
  }
  return triangle_tangent(corners, uvs);
}

/// The offset covers Embree's interpolation in float32: four roundings of a coordinate as large as the larger vertex,
/// and per part of the shutter one rounding of the time, times the vertex's motion.
TrianglePlane<float> DeformingMesh::plane(std::uint32_t primitive, float time) const noexcept {
  const auto [v0, v1, v2] = corners(primitive, time);
  TrianglePlane<float> plane = triangle_plane(v0, v1, v2);
  const std::size_t before = between(time, mesh->later.size()).before;
  const std::vector<Vec3f>&a = vertices_at(*mesh, before), &b = vertices_at(*mesh, before + 1);
  Vec3d reach, way;
  for (const std::uint32_t i : mesh->triangles[primitive]) {
    reach = max(reach, Vec3d(max(abs(a[i]), abs(b[i]))));
    way = max(way, Vec3d(abs(b[i] - a[i])));
  }
  const Vec3d off = reach * 4.0 + way * static_cast<double>(mesh->later.size() + 1);
  plane.offset += static_cast<float>(dot(abs(plane.n), off)) * kUnitRoundoff;
  return plane;
}

}  // namespace equaltime
