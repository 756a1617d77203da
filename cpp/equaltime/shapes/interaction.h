// Interaction: a point where a ray hits a surface or a medium scatters, and the rays that leave it. Normalised space.
#pragma once

#include <cstdint>

#include "equaltime/base/effects.h"
#include "equaltime/base/index.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/point.h"
#include "equaltime/math/ray.h"

namespace equaltime {

/// A point on a surface with its normal. A ray from the point, moved by `offset` along the normal, cannot hit the same
/// surface again: `offset` bounds the rounding of the point and the error of Embree's plane equation.
template <class Real>
struct OffsetPoint {
  Vec3<Real> p;
  Vec3<Real> n;  // unit geometric normal
  Real offset;   // >= 0

  /// The point moved off the surface, to the side of the normal or the other.
  [[nodiscard]] EQUALTIME_INLINE Vec3<Real> moved(Mask<Real> above) const noexcept {
    const Real height = where(
        above, [&] { return offset; }, [&] { return -offset; });
    return p + n * height;
  }
};

struct Interaction {
  OffsetPoint<float> anchor;  // normal on the side that the ray came from
  Frame frame;                // shading frame, its normal on that side too
  Vec3f wo;                   // unit, back along the ray
  std::uint32_t shape;
  std::uint32_t primitive;
  bool front;  // the ray came from the front side of the surface

  bool smooth;      // the shading normal is interpolated, so that it may differ from the geometric one
  Point2f prim_uv;  // of textured surfaces only: barycentric on a triangle, uv elsewhere

  std::uint32_t instance;  // that the surface is seen in, or kNone

  Vec3f unperturbed_normal;  // the shading normal before a normal or bump map
  float terminator_alpha2;   // squared roughness of the perturbed normal's shadowing; 0: none

  /// Whether the point lies in a medium, and not on a surface.
  [[nodiscard]] bool in_medium() const noexcept { return shape == kNone; }

  /// The ray that leaves in direction wi. `above`: wi is on the side of the geometric normal.
  [[nodiscard]] EQUALTIME_INLINE Ray spawn(const Vec3f& wi, bool above) const noexcept {
    return {anchor.moved(above), wi};
  }
  /// The ray to a point at some distance whose normal faces this one, ending short of its surface: t_max is 1.
  [[nodiscard]] EQUALTIME_INLINE Ray spawn_to(const OffsetPoint<float>& to, float distance, bool above) const noexcept {
    Vec3f origin = anchor.moved(above);
    // The direction is rounded too, by an error that grows with the distance: the far end gives way for it.
    const Vec3f target = to.p + to.n * (to.offset + 8 * kUnitRoundoff * distance);
    return {origin, target - origin, 1.0F};
  }
};

/// The nearest hit of a ray, if any.
template <bool kExact>
struct BasicSurfaceIntersection {
  Optional<Interaction> it;
};
/// The hit and its point in float64: in dense media, float32 would lose many mean free paths.
template <>
struct BasicSurfaceIntersection<true> {
  Optional<Interaction> it;
  Vec3d point;
};
using ExactIntersection = BasicSurfaceIntersection<true>;

/// The nearest hit in kernels for a set of effects: exact in those with media.
template <Effects E>
using SurfaceIntersection = BasicSurfaceIntersection<E.media>;

}  // namespace equaltime
