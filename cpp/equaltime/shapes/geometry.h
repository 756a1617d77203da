// The primitives that rays meet, and where exactly a ray meets them.
// Embree (or a quadratic in float64) says which primitive is hit; the functions here recompute the point from the
// primitive itself in float64, so that it does not depend on Embree's instruction set. All values share one space: the
// scene's normalised space (see math/normalization.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "equaltime/base/optional.h"
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

struct SphereGeometry {
  Vec3d center;
  double radius;
};

struct DiskGeometry {
  Vec3d center;
  Vec3d normal;  // unit
  Vec3d inv_u;   // dual axes: u = inv_u·(p - center), v likewise; inside where u² + v² <= 1
  Vec3d inv_v;
};

struct CylinderGeometry {  // a tube without caps
  Vec3d base;
  Vec3d axis;  // unit, from the base to the other end
  double length, radius;
};

/// Barycentric coordinates of a point on a triangle: u, v >= 0, u + v <= 1, p = v0 + u·e1 + v·e2.
struct Barycentric {
  float u, v;
};
[[nodiscard]] Barycentric barycentric(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, const Vec3d& point) noexcept;

namespace detail {
/// The t, in ascending order, at which oc + t·d, in any number of dimensions, is at the distance `radius` from 0. None
/// if d is 0 or misses, or if both are surely below 0.
struct Roots {
  double first, second;
};
[[nodiscard]] inline Optional<Roots> ball_roots(const Vec3d& oc, const Vec3d& d, double radius) noexcept {
  const double b = -dot(oc, d), distance_squared = length_squared(oc), radius_squared = square(radius);
  // Outside and on the way out, as rays mostly are that the ball's box stands round: the roots below keep their signs
  // when they are rounded, because the root of a square is the number itself. No root, no quotient for these.
  if (b < 0 && distance_squared >= radius_squared) return std::nullopt;
  const double a = length_squared(d);
  const Vec3d closest = oc + d * (b / a);
  const double discriminant = radius_squared - length_squared(closest);
  if (!(discriminant >= 0)) return std::nullopt;
  // c = |oc|² - r², from |oc| - r so that an origin close to the surface keeps its side.
  const double distance = std::sqrt(distance_squared);
  const double c = (distance - radius) * (distance + radius);
  const double q = b + std::copysign(std::sqrt(a * discriminant), b);
  const double t0 = q != 0 ? c / q : 0.0, t1 = q / a;
  return t0 > t1 ? Roots{t1, t0} : Roots{t0, t1};
}
}  // namespace detail

/// Nearest t in (0, t_max) at which the ray meets the sphere, with float64 accuracy for any ratio of distance and
/// radius (Haines, Günther & Akenine-Möller 2019: discriminant from the point of closest approach).
[[nodiscard]] inline Optional<double> intersect_sphere(const SphereGeometry& sphere, const RayD& ray) noexcept {
  const auto t = detail::ball_roots(ray.origin - sphere.center, ray.direction, sphere.radius);
  if (!t) return std::nullopt;
  if (t->first > 0) return t->first < ray.t_max ? Optional(t->first) : std::nullopt;
  if (t->second > 0 && t->second < ray.t_max) return t->second;
  return std::nullopt;
}
[[nodiscard]] Optional<double> intersect_disk(const DiskGeometry& disk, const RayD& ray) noexcept;
[[nodiscard]] Optional<double> intersect_cylinder(const CylinderGeometry& cylinder, const RayD& ray) noexcept;

}  // namespace equaltime
