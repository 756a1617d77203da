// Exact hits: where a ray meets the primitive that Embree found. The point is computed from the primitive itself in
// float64, so that it does not depend on Embree's instruction set. Each shape has one function, a template over Real
// (base/lanes.h).
#pragma once

#include "equaltime/base/lanes.h"
#include "equaltime/math/ray.h"
#include "equaltime/math/vector.h"
#include "equaltime/shapes/geometry.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

/// A point of a shape, before the side of the surface is known.
template <class Real>
struct ShapeHit {
  Vec3<Double<Real>> p, n;  // n: unit, geometric
  Real offset;              // as in OffsetPoint
};

template <class Real>
struct CylinderHit {
  ShapeHit<Real> hit;
  Double<Real> height;  // from the base, along the axis
};

/// The hit without what only some shapes have.
[[nodiscard]] inline const ShapeHit<float>& shape_hit(const ShapeHit<float>& hit) noexcept { return hit; }
[[nodiscard]] inline const ShapeHit<float>& shape_hit(const CylinderHit<float>& hit) noexcept { return hit.hit; }

namespace detail {
/// The hit at a point with a unit normal. Its offset bounds the rounding of the point to float32.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE ShapeHit<Real> rounded_hit(const Vec3<Double<Real>>& p,
                                                          const Vec3<Double<Real>>& n) noexcept {
  return {p, n, point_offset(Vec3<Real>(p), Vec3<Real>(n))};
}

/// Parameter of the ray at its point nearest to `to`. Used if Embree reports a hit in float32 that misses in float64.
template <class Real>
[[nodiscard]] inline Double<Real> nearest(const BasicRayD<Real>& ray, const Vec3<Double<Real>>& to) noexcept {
  return dot(to - ray.origin, ray.direction) / length_squared(ray.direction);
}
}  // namespace detail

template <class Real>
[[nodiscard]] EQUALTIME_INLINE ShapeHit<Real> exact_hit(const Sphere<Real>& sphere,
                                                        const BasicRayD<Real>& ray) noexcept {
  const auto hit = intersect(sphere, ray);
  const Double<Real> t = where(
      hit.has_value(), [&] { return *hit; }, [&] { return detail::nearest(ray, sphere.center); });
  const Vec3<Double<Real>> n = normalize(ray.origin + ray.direction * t - sphere.center);
  return detail::rounded_hit<Real>(sphere.center + n * sphere.radius, n);
}

template <class Real>
[[nodiscard]] EQUALTIME_INLINE ShapeHit<Real> exact_hit(const Disk<Real>& disk, const BasicRayD<Real>& ray) noexcept {
  const Double<Real> slope = dot(disk.normal, ray.direction);
  const Double<Real> t = where(
      slope != 0, [&] { return dot(disk.normal, disk.center - ray.origin) / slope; },
      [&] { return detail::nearest(ray, disk.center); });
  return detail::rounded_hit<Real>(ray.origin + ray.direction * t, disk.normal);
}

template <class Real>
[[nodiscard]] EQUALTIME_INLINE CylinderHit<Real> exact_hit(const Cylinder<Real>& cylinder,
                                                           const BasicRayD<Real>& ray) noexcept {
  const auto hit = intersect(cylinder, ray);
  const Double<Real> t = where(
      hit.has_value(), [&] { return *hit; },
      [&] { return detail::nearest(ray, cylinder.base + cylinder.axis * (0.5 * cylinder.length)); });
  const Vec3<Double<Real>> r = ray.origin + ray.direction * t - cylinder.base;
  const Double<Real> along = dot(r, cylinder.axis);
  const Double<Real> height = where(
      hit.has_value(), [&] { return along; }, [&] { return clamp(along, 0, cylinder.length); });
  const Vec3<Double<Real>> n = normalize(r - cylinder.axis * along);
  return {detail::rounded_hit<Real>(cylinder.base + cylinder.axis * height + n * cylinder.radius, n), height};
}

// A point that is on a shape but for its rounding, as a hit: its offset is not computed.

[[nodiscard]] inline ShapeHit<float> hit_at(const Sphere<float>& sphere, const Vec3d& p) noexcept {
  return {p, normalize(p - sphere.center), 0};
}
[[nodiscard]] inline ShapeHit<float> hit_at(const Disk<float>& disk, const Vec3d& p) noexcept {
  return {p, disk.normal, 0};
}
[[nodiscard]] inline CylinderHit<float> hit_at(const Cylinder<float>& cylinder, const Vec3d& p) noexcept {
  const double height = dot(p - cylinder.base, cylinder.axis);
  return {{p, normalize(p - cylinder.base - cylinder.axis * height), 0}, height};
}

/// Barycentric coordinates of a point on a triangle: u, v >= 0, u + v <= 1, p = v0 + u·e1 + v·e2.
template <class Real>
struct Barycentric {
  Real u, v;
};
template <class Real>
[[nodiscard]] inline Barycentric<Real> barycentric(const Vec3<Real>& v0, const Vec3<Real>& v1, const Vec3<Real>& v2,
                                                   const Vec3<Double<Real>>& point) noexcept {
  using Vector = Vec3<Double<Real>>;
  const Vector a(v0), e1 = Vector(v1) - a, e2 = Vector(v2) - a, r = point - a;
  const Vector n = cross(e1, e2);
  const Double<Real> inv = 1 / length_squared(n);
  const Double<Real> u = clamp(dot(cross(r, e2), n) * inv, 0, 1);
  const Double<Real> v = clamp(dot(cross(e1, r), n) * inv, 0, 1 - u);
  return {Real(u), Real(v)};
}

/// The unit normal between those of the corners, which have any length; that of the plane if they cancel.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE Vec3<Real> interpolated_normal(const Vec3<Real>& n0, const Vec3<Real>& n1,
                                                              const Vec3<Real>& n2, const Barycentric<Real>& at,
                                                              const Vec3<Real>& plane) noexcept {
  const Vec3<Real> sum = n0 * (1 - at.u - at.v) + n1 * at.u + n2 * at.v;
  return where(
      length_squared(sum) > 0, [&] { return normalize(sum); }, [&] { return plane; });
}

}  // namespace equaltime
