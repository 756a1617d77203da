// Nearby surfaces: safe origins of rays from vertices in a medium. In a dense medium, most vertices are so close to a
// surface that float32 and Embree cannot tell their side of it. So distances to surfaces are computed in float64, and
// Embree's rays begin at points that are surely on the right side.
#pragma once

#include <array>

#include "equaltime/shapes/interaction.h"

namespace equaltime {

/// Ray parameter of the hit surface's plane on the ray from a point, in float64.
[[nodiscard]] EQUALTIME_INLINE double distance_along(const Vec3d& from, const Vec3f& direction,
                                                     const ExactIntersection& to) noexcept {
  const Vec3d d(direction), n(to.it->anchor.n), way = to.point - from;
  const double slope = dot(n, d);
  return std::max(0.0, slope != 0 ? dot(n, way) / slope : dot(way, d));
}

/// Up to two surfaces whose distance from the path is below the offset of rays that leave them. A third one would
/// matter only in a corner of three surfaces. Other surfaces get close only when the path's ray is about to hit them.
class NearbySurfaces {
 public:
  /// Adds the surface that the path leaves. `normal` is on the side that the path goes to.
  void leave(const Vec3d& point, const Vec3f& normal, float offset) noexcept {
    add({Vec3d(normal), dot(Vec3d(normal), point), static_cast<double>(offset)});
  }
  /// Forgets all surfaces: the path is outside all media.
  void clear() noexcept { count_ = 0; }
  /// Returns a safe origin of rays from a vertex in a medium. `height` is the vertex's distance to the surface ahead,
  /// along its normal, if there is one.
  [[nodiscard]] EQUALTIME_INLINE Vec3f begin(Vec3d vertex, const ExactIntersection& ahead, float height) noexcept {
    if (count_ != 0) forget_far(vertex);
    if (ahead.it && height < ahead.it->anchor.offset) leave(ahead.point, ahead.it->anchor.n, ahead.it->anchor.offset);
    if (count_ != 0) vertex = clear_of(vertex);
    return Vec3f(vertex);
  }

 private:
  /// A surface as it is around the path, on the side of the normal.
  struct Plane {
    Vec3d normal;
    double d, offset;
    [[nodiscard]] double height(const Vec3d& place) const noexcept { return dot(normal, place) - d; }
  };
  /// The cosine of normals of one plane, or nearly one.
  static constexpr double kSamePlane = 1 - 0x1p-16;

  /// Adds a plane in the place of itself, seen from whichever side before, or else of the one known longest.
  [[gnu::noinline]] void add(const Plane& plane) noexcept {
    if (count_ != 0 && std::abs(dot(plane.normal, planes_[0].normal)) < kSamePlane) planes_[1] = planes_[0], count_ = 2;
    planes_[0] = plane;
    count_ = std::max(count_, 1U);
  }
  void forget_far(const Vec3d& place) noexcept {
    unsigned kept = 0;
    for (unsigned i = 0; i < count_; ++i)
      if (std::abs(planes_[i].height(place)) < planes_[i].offset) planes_[kept++] = planes_[i];
    count_ = kept;
  }
  [[nodiscard, gnu::noinline]] Vec3d clear_of(Vec3d place) const noexcept {
    for (unsigned i = 0; i < count_; ++i)
      place = place + planes_[i].normal * std::max(0.0, planes_[i].offset - planes_[i].height(place));
    return place;
  }

  std::array<Plane, 2> planes_;
  unsigned count_ = 0;
};

}  // namespace equaltime
