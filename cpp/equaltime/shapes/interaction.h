// Interaction: a point where a ray met a surface, with what leaving it again needs. Normalised space.
#pragma once

#include <cstdint>
#include <type_traits>

#include "equaltime/base/effects.h"
#include "equaltime/base/index.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/point.h"
#include "equaltime/math/ray.h"

namespace equaltime {

/// A point on a surface with its normal and the distance along the normal that surely clears the surface.
/// The distance bounds the rounding of the point and the error of Embree's plane equation: it is relative to both.
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

  bool smooth;    // the shading normal is interpolated, so that it may differ from the geometric one
  Point2f place;  // on a textured surface: barycentric on a triangle, uv elsewhere

  std::uint32_t instance;  // that the surface is seen in, or kNone

  Vec3f unbent;     // the shading normal before a texture bent it
  float shadowing;  // by a bent normal: the squared roughness of its model; 0 if there is none

  /// The ray that leaves in a direction of which it is known whether it is above the surface.
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

/// What a ray meets, if anything, with the point as it was before it was rounded to float32: in dense media, that loses
/// many mean free paths.
struct ExactMeeting {
  Optional<Interaction> it;
  Vec3d point;
};

/// The result of a ray in kernels for these effects: with the exact point where there are media.
template <Effects E>
using MeetingOf = std::conditional_t<E.media, ExactMeeting, Optional<Interaction>>;

/// The interaction of a meeting.
[[nodiscard]] inline Optional<Interaction>& surface(Optional<Interaction>& it) noexcept { return it; }
[[nodiscard]] inline Optional<Interaction>& surface(ExactMeeting& meeting) noexcept { return meeting.it; }
[[nodiscard]] inline const Optional<Interaction>& surface(const Optional<Interaction>& it) noexcept { return it; }
[[nodiscard]] inline const Optional<Interaction>& surface(const ExactMeeting& meeting) noexcept { return meeting.it; }

}  // namespace equaltime
