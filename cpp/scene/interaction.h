// Interaction: a point where a ray met a surface, with what leaving it again needs. Normalised space.
#pragma once

#include <cstdint>

#include "math/frame.h"
#include "math/ray.h"

namespace equaltime {

/// A point on a surface with its normal and the distance along the normal that surely clears the surface.
/// The distance bounds the rounding of the point and the error of Embree's plane equation: it is relative to both.
struct SurfaceAnchor {
  Vec3f p;
  Vec3f n;       // unit geometric normal
  float offset;  // >= 0

  /// The point moved off the surface, to the side of `towards`.
  [[nodiscard]] EQUALTIME_INLINE Vec3f moved_towards(const Vec3f& towards) const noexcept {
    return p + n * (dot(n, towards) < 0 ? -offset : offset);
  }
};

struct Interaction {
  SurfaceAnchor anchor;  // normal on the side that the ray came from
  Frame frame;           // shading frame, its normal on that side too
  Vec3f wo;              // unit, back along the ray
  std::uint32_t shape;
  std::uint32_t primitive;
  bool front;  // the ray came from the front side of the surface

  [[nodiscard]] EQUALTIME_INLINE Ray spawn(const Vec3f& wi) const noexcept { return {anchor.moved_towards(wi), wi}; }
};

/// The ray from one anchored point to another, ending short of what stands at its far end: t_max is 1.
[[nodiscard]] EQUALTIME_INLINE Ray spawn_between(const SurfaceAnchor& from, const SurfaceAnchor& to) noexcept {
  const Vec3f d = to.p - from.p;
  const Vec3f origin = from.moved_towards(d);
  // The direction is rounded too, by an error that grows with the distance: the far end gives way for it.
  const float give = to.offset + 8 * kUnitRoundoff * dot(abs(to.n), abs(d));
  const Vec3f target = to.p + to.n * (dot(to.n, d) > 0 ? -give : give);
  return {origin, target - origin, 1.0F};
}

}  // namespace equaltime
