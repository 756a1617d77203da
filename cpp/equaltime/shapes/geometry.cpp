#include "equaltime/shapes/geometry.h"

namespace equaltime {

std::array<Vec3f, 3> corners_at(const TriangleMesh& mesh, std::uint32_t triangle, float time) noexcept {
  const auto [before, fraction] = between(time, mesh.later.size());
  const std::vector<Vec3f>&a = vertices_at(mesh, before), &b = vertices_at(mesh, before + 1);
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mixed(a[i], b[i], fraction), mixed(a[j], b[j], fraction), mixed(a[k], b[k], fraction)};
}

}  // namespace equaltime
