// Points on exact surfaces as float32 has them: how far they may be off, and the planes of triangles.
#pragma once

#include "equaltime/math/numeric.h"
#include "equaltime/math/ray.h"
#include "equaltime/math/vector.h"

namespace equaltime {

/// Bound of what float64 leaves between a computed point and its surface, anywhere in normalised space (2^11 across,
/// some ten roundings). In a plane through the origin it is all there is, and enough to put a point behind it.
inline constexpr float kExactOffset = 0x1p-37F;

/// Bound of the rounding of a float32 point on an exact (float64) surface with unit normal n.
template <class Real>
[[nodiscard]] inline Real point_offset(const Vec3<Real>& p, const Vec3<Real>& n) noexcept {
  return 4 * kUnitRoundoff * dot(abs(n), abs(p)) + kExactOffset;
}

/// The plane of a triangle, and how far from it a ray must start so as not to meet the triangle. One record holds all
/// that a flat triangle's interaction needs: neither its vertices nor their indices are read.
template <class Real>
struct TrianglePlane {
  Vec3<Double<Real>> n;  // unit geometric normal
  Double<Real> d;        // n·p of the plane's points
  Real offset;

  /// The point of the triangle that Embree says is hit: on the ray, and on the plane to float64.
  [[nodiscard]] EQUALTIME_INLINE Vec3<Double<Real>> meet(const BasicRayD<Real>& ray) const noexcept {
    const Double<Real> slope = dot(ray.direction, n);
    // A ray within the plane meets it in no single point: its own origin, which is in the plane, stands for it.
    const Double<Real> t = where(slope != 0, [&] { return (d - dot(ray.origin, n)) / slope; });
    return ray.origin + ray.direction * t;
  }
};

/// Embree's robust test translates the vertices to the ray's origin and forms the plane from their rounded differences;
/// the terms of the offset bound, in order, the rounding of a point on the triangle, of the translated vertices and of
/// the plane's normal. Tested on random triangles (tests/hard).
template <class Real>
[[nodiscard]] inline TrianglePlane<Real> triangle_plane(const Vec3<Real>& v0, const Vec3<Real>& v1,
                                                        const Vec3<Real>& v2) noexcept {
  using Vector = Vec3<Double<Real>>;
  const Vector a(v0), scaled_normal = cross(Vector(v1) - a, Vector(v2) - a);
  const Double<Real> norm = length(scaled_normal);
  const Vector n = scaled_normal / norm;
  const Vector reach(max(abs(v0), max(abs(v1), abs(v2))));
  const Vector e(max(abs(v1 - v0), max(abs(v2 - v0), abs(v2 - v1))));
  const Double<Real> bound = dot(abs(n), reach + e) + 3 * e.x * e.y * e.z / norm;
  return {n, dot(n, a), Real(4 * static_cast<double>(kUnitRoundoff) * bound) + kExactOffset};
}

}  // namespace equaltime
