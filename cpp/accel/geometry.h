// The primitives that rays meet, and where exactly a ray meets them.
// Embree (or a quadratic in float64) says which primitive is hit; the functions here recompute the point from the
// primitive itself in float64, so that it does not depend on Embree's instruction set. All values share one space: the
// scene's normalised space (see scene/normalization.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "math/ray.h"
#include "math/vector.h"

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
  double share;
};
[[nodiscard]] inline Between between(float time, std::size_t parts) noexcept {
  const double at = static_cast<double>(time) * static_cast<double>(parts);
  const std::size_t before = std::min(static_cast<std::size_t>(at), parts - 1);
  return {before, at - static_cast<double>(before)};
}

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

/// Nearest t in (0, t_max) at which the ray meets the sphere, with float64 accuracy for any ratio of distance and
/// radius (Haines, Günther & Akenine-Möller 2019: discriminant from the point of closest approach).
[[nodiscard]] std::optional<double> intersect_sphere(const SphereGeometry& sphere, const RayD& ray) noexcept;
[[nodiscard]] std::optional<double> intersect_disk(const DiskGeometry& disk, const RayD& ray) noexcept;
[[nodiscard]] std::optional<double> intersect_cylinder(const CylinderGeometry& cylinder, const RayD& ray) noexcept;

}  // namespace equaltime
