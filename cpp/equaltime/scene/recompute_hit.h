// The exact hit of the primitive that Embree found, with what textures and anisotropic BSDFs ask for, and the
// interaction there. Rays and points are in the primitive's own space.
#pragma once

#include "equaltime/accel/accel.h"
#include "equaltime/base/effects.h"
#include "equaltime/scene/surface.h"
#include "equaltime/shapes/exact_hit.h"
#include "equaltime/shapes/interaction.h"

namespace equaltime {

/// One mesh as shading reads it: views into the arrays of Accel and Surface.
struct MeshView {
  const Triangle* triangles;
  const Vec3f* vertices;
  const TrianglePlane<float>* planes;
  const Vec3f* normals;   // null: flat
  const Vec3f* tangents;  // one a triangle; null: no BSDF looks at them
  const Point2f* uvs;     // null: none, or no texture looks at them
  bool textured;
  std::uint32_t shape;
  bool flipped;
};

namespace detail {

/// The exact hit, with what shading asks for.
struct SurfacePoint {
  ShapeHit<float> hit;
  Vec3f shading_normal;
  Vec3f tangent;  // of any length; zero where none matters
  std::uint32_t shape, primitive;
  bool flipped, smooth;
  Point2f prim_uv;
};

/// The interaction on the side that the ray, whose direction is unit, came from. An Interaction is that of one path.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE Interaction make_interaction(const SurfacePoint& point, const Ray& ray) noexcept {
  const Vec3f n(point.hit.n);
  const float side = dot(ray.direction, n) > 0 ? -1.0F : 1.0F;
  const Vec3f ns = point.shading_normal * side;
  Frame frame;
  if constexpr (E.anisotropy)
    frame = Frame::from_tangent(ns, point.tangent);
  else
    frame = Frame::from_normal(ns);
  OffsetPoint<float> anchor{Vec3f(point.hit.p), n * side, point.hit.offset};
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
    return {make_interaction<E>(point, ray), point.hit.p};
  else
    return {make_interaction<E>(point, ray)};
}

// Parts of a hit that depend on the kind of an analytic shape. Hits are passed by value: references would force them
// into memory even where no part is asked for.

/// The direction in which u grows, of any length.
[[nodiscard]] inline Vec3f tangent_at(const Sphere<float>&, const ShapeParametrization& s,
                                      ShapeHit<float> hit) noexcept {
  return cross(s.pole, Vec3f(hit.n));
}
[[nodiscard]] inline Vec3f tangent_at(const Disk<float>& disk, const ShapeParametrization&,
                                      ShapeHit<float> hit) noexcept {
  return Vec3f(hit.p - disk.center);
}
[[nodiscard]] inline Vec3f tangent_at(const Cylinder<float>& cylinder, const ShapeParametrization&,
                                      CylinderHit<float> hit) noexcept {
  return Vec3f(cross(cylinder.axis, hit.hit.n));
}

/// Azimuth and polar angle, in whole turns and half turns.
[[nodiscard]] Point2f uv_at(const Sphere<float>&, const ShapeParametrization& s, ShapeHit<float> hit) noexcept;
/// Distance from the centre, in radii, and azimuth, in turns.
[[nodiscard]] Point2f uv_at(const Disk<float>& disk, const ShapeParametrization&, ShapeHit<float> hit) noexcept;
/// Azimuth, in turns, and height, from 0 at the base to 1.
[[nodiscard]] Point2f uv_at(const Cylinder<float>& cylinder, const ShapeParametrization& s,
                            CylinderHit<float> hit) noexcept;

/// A point of an analytic shape: its shading normal is the geometric one.
template <Effects E, class Shape, class Hit>
[[nodiscard]] EQUALTIME_INLINE SurfacePoint point_of(const Shape& geometry, Hit hit, const Surface& surface,
                                                     std::uint32_t shape) noexcept {
  SurfacePoint point{shape_hit(hit), Vec3f(shape_hit(hit).n), {}, shape, 0, surface.flipped, false, {}};
  if constexpr (E.anisotropy)
    if (surface.anisotropic) point.tangent = tangent_at(geometry, surface.analytic, hit);
  if constexpr (E.textures)
    if (surface.textured) point.prim_uv = uv_at(geometry, surface.analytic, hit);
  return point;
}

template <Effects E, class Shape>
[[nodiscard]] SurfacePoint recompute_hit(const Shape& geometry, const Surface& surface, const RayD& ray,
                                         std::uint32_t shape) noexcept {
  return point_of<E>(geometry, exact_hit(geometry, ray), surface, shape);
}

template <Effects E>
[[nodiscard]] EQUALTIME_INLINE SurfacePoint recompute_hit(const MeshView& mesh, const RayD& ray,
                                                          std::uint32_t primitive) noexcept {
  const TrianglePlane<float>& plane = mesh.planes[primitive];
  Vec3d p = plane.meet(ray);
  const bool smooth = E.smooth_normals && mesh.normals != nullptr;
  const bool textured = E.textures && mesh.textured;
  Vec3f ns(plane.n);
  Point2f prim_uv{};
  if (smooth || textured) {
    const Triangle& t = mesh.triangles[primitive];
    const auto at = barycentric(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]], p);
    if (smooth) ns = interpolated_normal(mesh.normals[t[0]], mesh.normals[t[1]], mesh.normals[t[2]], at, ns);
    if (textured) prim_uv = {at.u, at.v};
  }
  Vec3f tangent;
  if constexpr (E.anisotropy)
    if (mesh.tangents != nullptr) tangent = mesh.tangents[primitive];
  return {{p, plane.n, plane.offset}, ns, tangent, mesh.shape, primitive, mesh.flipped, smooth, prim_uv};
}

}  // namespace detail

}  // namespace equaltime
