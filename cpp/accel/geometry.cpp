#include "accel/geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

namespace {

/// Where oc + t·d, in any number of dimensions, is at the distance `radius` from 0; none if d is 0 or misses.
std::optional<std::pair<double, double>> meet_ball(const Vec3d& oc, const Vec3d& d, double radius) noexcept {
  const double a = length_squared(d);
  const double b = -dot(oc, d);
  const Vec3d closest = oc + d * (b / a);
  const double discriminant = square(radius) - length_squared(closest);
  if (!(discriminant >= 0)) return std::nullopt;
  // c = |oc|² - r², from |oc| - r so that an origin close to the surface keeps its side.
  const double distance = length(oc);
  const double c = (distance - radius) * (distance + radius);
  const double q = b + std::copysign(std::sqrt(a * discriminant), b);
  const double t0 = q != 0 ? c / q : 0.0, t1 = q / a;
  return t0 > t1 ? std::pair(t1, t0) : std::pair(t0, t1);
}

}  // namespace

std::optional<double> intersect_sphere(const SphereGeometry& sphere, const RayD& ray) noexcept {
  const auto meetings = meet_ball(ray.origin - sphere.center, ray.direction, sphere.radius);
  if (!meetings) return std::nullopt;
  const auto [t0, t1] = *meetings;
  if (t0 > 0) return t0 < ray.t_max ? std::optional(t0) : std::nullopt;
  if (t1 > 0 && t1 < ray.t_max) return t1;
  return std::nullopt;
}

std::optional<double> intersect_disk(const DiskGeometry& disk, const RayD& ray) noexcept {
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

std::optional<double> intersect_cylinder(const CylinderGeometry& cylinder, const RayD& ray) noexcept {
  const Vec3d &d = ray.direction, oc = ray.origin - cylinder.base;
  const double rise = dot(d, cylinder.axis), start = dot(oc, cylinder.axis);
  const auto meetings = meet_ball(oc - cylinder.axis * start, d - cylinder.axis * rise, cylinder.radius);
  if (!meetings) return std::nullopt;
  for (const double t : {meetings->first, meetings->second}) {
    const double height = start + rise * t;
    if (t > 0 && t < ray.t_max && height >= 0 && height <= cylinder.length) return t;
  }
  return std::nullopt;
}

}  // namespace equaltime
