#include "equaltime/shapes/geometry.h"

#include <cmath>

#include "equaltime/math/elementary.h"

namespace equaltime {

std::array<Vec3f, 3> corners_at(const TriangleMesh& mesh, std::uint32_t triangle, float time) noexcept {
  const auto [before, fraction] = between(time, mesh.later.size());
  const std::vector<Vec3f>&a = vertices_at(mesh, before), &b = vertices_at(mesh, before + 1);
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mixed(a[i], b[i], fraction), mixed(a[j], b[j], fraction), mixed(a[k], b[k], fraction)};
}

Bounds box_of(const Sphere<float>& s) noexcept {
  const Vec3d half{s.radius, s.radius, s.radius};
  return {s.center - half, s.center + half};
}

Bounds box_of(const Disk<float>& d) noexcept {
  // The axes are the duals of inv_u, inv_v within the plane; the ellipse reaches sqrt(u² + v²) along each coordinate.
  const double volume = dot(d.normal, cross(d.inv_u, d.inv_v));
  const Vec3d u = cross(d.inv_v, d.normal) / volume;
  const Vec3d v = cross(d.normal, d.inv_u) / volume;
  const Vec3d half{elementary::hypot(u.x, v.x), elementary::hypot(u.y, v.y), elementary::hypot(u.z, v.z)};
  return {d.center - half, d.center + half};
}

Bounds box_of(const Cylinder<float>& c) noexcept {
  const auto reach = [&](double a) {
    return 0.5 * c.length * std::abs(a) + c.radius * std::sqrt(std::max(0.0, 1 - a * a));
  };
  const Vec3d center = c.base + c.axis * (0.5 * c.length), half{reach(c.axis.x), reach(c.axis.y), reach(c.axis.z)};
  return {center - half, center + half};
}

}  // namespace equaltime
