#include "equaltime/shapes/geometry.h"

#include <algorithm>

namespace equaltime {

Barycentric barycentric(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, const Vec3d& point) noexcept {
  const Vec3d a(v0);
  const Vec3d e1 = Vec3d(v1) - a, e2 = Vec3d(v2) - a, r = point - a;
  const Vec3d n = cross(e1, e2);
  const double inv = 1 / length_squared(n);
  const double u = std::clamp(dot(cross(r, e2), n) * inv, 0.0, 1.0);
  const double v = std::clamp(dot(cross(e1, r), n) * inv, 0.0, 1.0 - u);
  return {static_cast<float>(u), static_cast<float>(v)};
}

Optional<double> intersect_disk(const DiskGeometry& disk, const RayD& ray) noexcept {
  const Vec3d& d = ray.direction;
  const Vec3d to_center = disk.center - ray.origin;
  const double cosine = dot(disk.normal, d);
  if (cosine == 0) return std::nullopt;
  const double t = dot(disk.normal, to_center) / cosine;
  if (!(t > 0 && t < ray.t_max)) return std::nullopt;
  const Vec3d r = d * t - to_center;
  if (square(dot(disk.inv_u, r)) + square(dot(disk.inv_v, r)) > 1) return std::nullopt;
  return t;
}

Optional<double> intersect_cylinder(const CylinderGeometry& cylinder, const RayD& ray) noexcept {
  const Vec3d &d = ray.direction, oc = ray.origin - cylinder.base;
  const double rise = dot(d, cylinder.axis), start = dot(oc, cylinder.axis);
  const auto roots = detail::ball_roots(oc - cylinder.axis * start, d - cylinder.axis * rise, cylinder.radius);
  if (!roots) return std::nullopt;
  for (const double t : {roots->first, roots->second}) {
    const double height = start + rise * t;
    if (t > 0 && t < ray.t_max && height >= 0 && height <= cylinder.length) return t;
  }
  return std::nullopt;
}

std::array<Vec3f, 3> corners_at(const TriangleMesh& mesh, std::uint32_t triangle, float time) noexcept {
  const auto [before, fraction] = between(time, mesh.later.size());
  const std::vector<Vec3f>&a = vertices_at(mesh, before), &b = vertices_at(mesh, before + 1);
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mixed(a[i], b[i], fraction), mixed(a[j], b[j], fraction), mixed(a[k], b[k], fraction)};
}

}  // namespace equaltime
