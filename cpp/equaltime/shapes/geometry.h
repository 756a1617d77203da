// The primitives that rays meet: triangles of meshes, and analytic shapes. All values share one space: the scene's
// normalised space (see math/normalization.h).
//
// An analytic shape has
//   name, and needs (an effect);
//   intersect(shape, ray): the t in float64 at which a ray meets it; box_of(shape); exact_hit (exact_hit.h);
//   what textures and anisotropic BSDFs ask for (scene/recompute_hit.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/lanes.h"
#include "equaltime/base/optional.h"
#include "equaltime/base/type_list.h"
#include "equaltime/math/bounds.h"
#include "equaltime/math/ray.h"
#include "equaltime/math/vector.h"

namespace equaltime {

using Triangle = std::array<std::uint32_t, 3>;

struct TriangleMesh {
  std::vector<Vec3f> vertices;
  std::vector<Triangle> triangles;
  /// Where the vertices are later, at evenly spaced times up to 1, if they move; at 0 they are as above.
  std::vector<std::vector<Vec3f>> later = {};
};

/// A place in a list that is evenly spaced over times from 0 to 1: between two, and how far.
struct Between {
  std::size_t before;
  double fraction;
};
[[nodiscard]] inline Between between(float time, std::size_t parts) noexcept {
  const double at = static_cast<double>(time) * static_cast<double>(parts);
  const std::size_t before = std::min(static_cast<std::size_t>(at), parts - 1);
  return {before, at - static_cast<double>(before)};
}

/// Between two points or normals, `fraction` of the way from a to b.
[[nodiscard]] inline Vec3f mixed(const Vec3f& a, const Vec3f& b, double fraction) noexcept {
  return Vec3f(Vec3d(a) * (1 - fraction) + Vec3d(b) * fraction);
}
/// The vertices of a mesh that deforms, at one of its times.
[[nodiscard]] inline const std::vector<Vec3f>& vertices_at(const TriangleMesh& mesh, std::size_t step) noexcept {
  return step == 0 ? mesh.vertices : mesh.later[step - 1];
}
/// The corners of a triangle of a mesh that deforms, at a time from 0 to 1.
[[nodiscard]] std::array<Vec3f, 3> corners_at(const TriangleMesh& mesh, std::uint32_t triangle, float time) noexcept;

template <class Real>
struct Sphere {
  static constexpr const char* name = "sphere";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;
  Vec3<Double<Real>> center;
  Double<Real> radius;
};

template <class Real>
struct Disk {
  static constexpr const char* name = "disk";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;
  Vec3<Double<Real>> center;
  Vec3<Double<Real>> normal;  // unit
  Vec3<Double<Real>> inv_u;   // dual axes: u = inv_u·(p - center), v likewise; inside where u² + v² <= 1
  Vec3<Double<Real>> inv_v;
};

template <class Real>
struct Cylinder {  // a tube without caps
  static constexpr const char* name = "cylinder";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;
  Vec3<Double<Real>> base;
  Vec3<Double<Real>> axis;  // unit, from the base to the other end
  Double<Real> length, radius;
};

using AnalyticShapes = TypeList<Sphere<float>, Disk<float>, Cylinder<float>>;

[[nodiscard]] Bounds box_of(const Sphere<float>& sphere) noexcept;
[[nodiscard]] Bounds box_of(const Disk<float>& disk) noexcept;
[[nodiscard]] Bounds box_of(const Cylinder<float>& cylinder) noexcept;

namespace detail {
/// Two t in ascending order.
template <LaneNumber T>
struct Roots {
  T first, second;
};
/// The t, in ascending order, at which oc + t·d, in any number of dimensions, is at the distance `radius` from 0. None
/// if d is 0 or misses, or if both are surely below 0.
template <LaneNumber T>
[[nodiscard]] inline Optional<Roots<T>> ball_roots(const Vec3<T>& oc, const Vec3<T>& d, T radius) noexcept {
  const T b = -dot(oc, d), distance_squared = length_squared(oc), radius_squared = square(radius);
  // Outside and on the way out, as rays mostly are that the ball's box stands round: both t are below 0, and stay so
  // when rounded, since sqrt(x²) is |x| exactly. So these rays need no square root and no division.
  const Mask<T> ahead = !(b < 0 && distance_squared >= radius_squared);
  if (none(ahead)) return std::nullopt;
  const T a = length_squared(d);
  const Vec3<T> closest = oc + d * (b / a);
  const T discriminant = radius_squared - length_squared(closest);
  const Mask<T> met = ahead && discriminant >= 0;
  if (none(met)) return std::nullopt;
  // c = |oc|² - r², from |oc| - r so that an origin close to the surface keeps its side.
  const T distance = sqrt(distance_squared);
  const T c = (distance - radius) * (distance + radius);
  const T q = b + copysign(sqrt(a * discriminant), b);
  const T t0 = where(q != 0, [&] { return c / q; }), t1 = q / a;
  return {{min(t0, t1), max(t1, t0)}, met};
}
}  // namespace detail

/// Nearest t in (0, t_max) at which the ray meets the sphere, with float64 accuracy for any ratio of distance and
/// radius (Haines, Günther & Akenine-Möller 2019: discriminant from the point of closest approach).
template <class Real>
[[nodiscard]] inline Optional<Double<Real>> intersect(const Sphere<Real>& sphere, const BasicRayD<Real>& ray) noexcept {
  const auto roots = detail::ball_roots(ray.origin - sphere.center, ray.direction, sphere.radius);
  if (none(roots.has_value())) return std::nullopt;
  const Double<Real> t = where(
      roots->first > 0, [&] { return roots->first; }, [&] { return roots->second; });
  return {t, roots.has_value() && t > 0 && t < ray.t_max};
}

template <class Real>
[[nodiscard]] inline Optional<Double<Real>> intersect(const Disk<Real>& disk, const BasicRayD<Real>& ray) noexcept {
  const Vec3<Double<Real>> to_center = disk.center - ray.origin;
  const Double<Real> cosine = dot(disk.normal, ray.direction);
  const Double<Real> t = where(cosine != 0, [&] { return dot(disk.normal, to_center) / cosine; });
  const Mask<Real> ahead = t > 0 && t < ray.t_max;
  if (none(ahead)) return std::nullopt;
  const Vec3<Double<Real>> r = ray.direction * t - to_center;
  return {t, ahead && square(dot(disk.inv_u, r)) + square(dot(disk.inv_v, r)) <= 1};
}

template <class Real>
[[nodiscard]] inline Optional<Double<Real>> intersect(const Cylinder<Real>& cylinder,
                                                      const BasicRayD<Real>& ray) noexcept {
  const Vec3<Double<Real>>&d = ray.direction, oc = ray.origin - cylinder.base;
  const Double<Real> rise = dot(d, cylinder.axis), start = dot(oc, cylinder.axis);
  const auto roots = detail::ball_roots(oc - cylinder.axis * start, d - cylinder.axis * rise, cylinder.radius);
  if (none(roots.has_value())) return std::nullopt;
  const auto on_tube = [&](Double<Real> t) {
    const Double<Real> height = start + rise * t;
    return t > 0 && t < ray.t_max && height >= 0 && height <= cylinder.length;
  };
  const Mask<Real> first = on_tube(roots->first);
  const Double<Real> t = where(
      first, [&] { return roots->first; }, [&] { return roots->second; });
  return {t, roots.has_value() && (first || on_tube(t))};
}

}  // namespace equaltime
