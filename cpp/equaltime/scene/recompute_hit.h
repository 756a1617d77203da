// Recomputes, in float64, where a ray hits the primitive that Embree found, and makes the interaction there. Rays and
// points are in the primitive's own space.
#pragma once

#include "equaltime/accel/accel.h"
#include "equaltime/base/effects.h"
#include "equaltime/scene/surface.h"
#include "equaltime/shapes/interaction.h"

namespace equaltime {

/// One mesh as shading reads it: views into the arrays of Accel and Surface.
struct MeshView {
  const Triangle* triangles;
  const Vec3f* vertices;
  const TrianglePlane* planes;
  const Vec3f* normals;   // null: flat
  const Vec3f* tangents;  // one a triangle; null: no BSDF looks at them
  const Point2f* uvs;     // null: none, or no texture looks at them
  bool textured;
  std::uint32_t shape;
  bool flipped;
};

namespace detail {

/// A hit point, before the side of the surface is known.
struct SurfacePoint {
  Vec3d p, n;    // n: unit, geometric
  float offset;  // as in OffsetPoint
  Vec3f shading_normal;
  Vec3f tangent;  // of any length; zero where none matters
  std::uint32_t shape, primitive;
  bool flipped, smooth;
  Point2f prim_uv;
};

/// The interaction on the side that the ray, whose direction is unit, came from.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE Interaction make_interaction(const SurfacePoint& point, const Ray& ray) noexcept {
  const Vec3f n(point.n);
  const float side = dot(ray.direction, n) > 0 ? -1.0F : 1.0F;
  const Vec3f ns = point.shading_normal * side;
  Frame frame;
  if constexpr (E.anisotropy)
    frame = Frame::from_tangent(ns, point.tangent);
  else
    frame = Frame::from_normal(ns);
  OffsetPoint<float> anchor{Vec3f(point.p), n * side, point.offset};
  return {anchor,
          frame,
          -ray.direction,
          point.shape,
          point.primitive,
          (side > 0) != point.flipped,
          point.smooth,
          point.prim_uv,
          kNone,
          {},
          0};
}
/// The interaction, with the exact point in kernels with media.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE SurfaceIntersection<E> make_intersection(const SurfacePoint& point,
                                                                        const Ray& ray) noexcept {
  if constexpr (E.media)
    return {make_interaction<E>(point, ray), point.p};
  else
    return make_interaction<E>(point, ray);
}

/// Azimuth and polar angle, in whole turns and half turns.
[[nodiscard]] Point2f sphere_uv(const Surface& surface, const Vec3f& n) noexcept;
/// Azimuth, in turns, and height, from 0 at the base to 1.
[[nodiscard]] Point2f cylinder_uv(const Surface& surface, const Vec3f& n, double height) noexcept;
/// Distance from the centre, in radii, and azimuth, in turns.
[[nodiscard]] Point2f disk_uv(const DiskGeometry& disk, const Vec3d& point) noexcept;

/// Parameter of the ray at its point nearest to `to`. Used if Embree reports a hit in float32 that misses in float64.
[[nodiscard]] inline double nearest(const RayD& ray, const Vec3d& to) noexcept {
  return dot(to - ray.origin, ray.direction) / length_squared(ray.direction);
}

template <Effects E>
[[nodiscard]] SurfacePoint recompute_hit(const SphereGeometry& sphere, const Surface& surface, const RayD& ray,
                                         std::uint32_t shape) noexcept {
  const auto hit = intersect_sphere(sphere, ray);
  const double t = hit ? *hit : nearest(ray, sphere.center);
  const Vec3d n = normalize(ray.origin + ray.direction * t - sphere.center);
  const Vec3d p = sphere.center + n * sphere.radius;
  const Vec3f nf(n);
  SurfacePoint point{p, n, point_offset(Vec3f(p), nf), nf, {}, shape, 0, surface.flipped, false, {}};
  if constexpr (E.anisotropy)
    if (surface.tangential) point.tangent = cross(surface.pole, nf);
  if constexpr (E.textures)
    if (surface.textured) point.prim_uv = sphere_uv(surface, nf);
  return point;
}

template <Effects E>
[[nodiscard]] SurfacePoint recompute_hit(const DiskGeometry& disk, const Surface& surface, const RayD& ray,
                                         std::uint32_t shape) noexcept {
  const double slope = dot(disk.normal, ray.direction);
  const double t = slope != 0 ? dot(disk.normal, disk.center - ray.origin) / slope : nearest(ray, disk.center);
  const Vec3d p = ray.origin + ray.direction * t;
  const Vec3f nf(disk.normal);
  SurfacePoint point{p, disk.normal, point_offset(Vec3f(p), nf), nf, {}, shape, 0, surface.flipped, false, {}};
  if constexpr (E.anisotropy)
    if (surface.tangential) point.tangent = Vec3f(p - disk.center);
  if constexpr (E.textures)
    if (surface.textured) point.prim_uv = disk_uv(disk, p);
  return point;
}

template <Effects E>
[[nodiscard]] SurfacePoint recompute_hit(const CylinderGeometry& cylinder, const Surface& surface, const RayD& ray,
                                         std::uint32_t shape) noexcept {
  const auto hit = intersect_cylinder(cylinder, ray);
  const double t = hit ? *hit : nearest(ray, cylinder.base + cylinder.axis * (0.5 * cylinder.length));
  const Vec3d r = ray.origin + ray.direction * t - cylinder.base;
  const double height = hit ? dot(r, cylinder.axis) : std::clamp(dot(r, cylinder.axis), 0.0, cylinder.length);
  const Vec3d n = normalize(r - cylinder.axis * dot(r, cylinder.axis));
  const Vec3d p = cylinder.base + cylinder.axis * height + n * cylinder.radius;
  const Vec3f nf(n);
  SurfacePoint point{p, n, point_offset(Vec3f(p), nf), nf, {}, shape, 0, surface.flipped, false, {}};
  if constexpr (E.anisotropy)
    if (surface.tangential) point.tangent = Vec3f(cross(cylinder.axis, n));
  if constexpr (E.textures)
    if (surface.textured) point.prim_uv = cylinder_uv(surface, nf, height / cylinder.length);
  return point;
}

template <Effects E>
[[nodiscard]] EQUALTIME_INLINE SurfacePoint recompute_hit(const MeshView& mesh, const RayD& ray,
                                                          std::uint32_t primitive) noexcept {
  const TrianglePlane& plane = mesh.planes[primitive];
  Vec3d p = plane.meet(ray);
  const bool smooth = E.smooth_normals && mesh.normals != nullptr;
  const bool textured = E.textures && mesh.textured;
  Vec3f ns(plane.n);
  Point2f prim_uv{};
  if (smooth || textured) {
    const Triangle& t = mesh.triangles[primitive];
    const Vec3f &v0 = mesh.vertices[t[0]], &v1 = mesh.vertices[t[1]], &v2 = mesh.vertices[t[2]];
    const auto [u, v] = barycentric(v0, v1, v2, p);
    if (smooth) {
      const Vec3f sum = mesh.normals[t[0]] * (1 - u - v) + mesh.normals[t[1]] * u + mesh.normals[t[2]] * v;
      if (length_squared(sum) > 0) ns = normalize(sum);
    }
    if (textured) prim_uv = {u, v};
  }
  Vec3f tangent;
  if constexpr (E.anisotropy)
    if (mesh.tangents != nullptr) tangent = mesh.tangents[primitive];
  return {p, plane.n, plane.offset, ns, tangent, mesh.shape, primitive, mesh.flipped, smooth, prim_uv};
}

}  // namespace detail

}  // namespace equaltime
