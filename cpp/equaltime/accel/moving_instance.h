// MovingInstance: a group of geometries, placed by a motion, whose rays this class takes to the group's space. Embree's
// own moving instances turn by fast approximations, which no offset of a ray could bound well. Where there are many,
// each is a geometry of Embree's; a few are met beside its tree, without the steps of one whose boxes move.
#pragma once

#include <cstdint>
#include <vector>

#include "equaltime/accel/embree_values.h"
#include "equaltime/math/motion.h"

namespace equaltime {

class MovingInstance {
 public:
  /// Its hits have this id as instID.
  MovingInstance(RTCScene group, const Motion& to_world, std::uint32_t id);

  /// The instance must stay where it is for as long as the geometry is used.
  [[nodiscard]] RTCGeometry new_geometry(RTCDevice device);
  /// Whether the ray may meet its box. The inverse is that of each coordinate of the direction.
  [[nodiscard]] bool near(const RTCRay& ray, Float4 inverse) const noexcept;
  /// Puts what the ray meets into the query, if that is nearer than what is there, and tells whether it is.
  bool intersect(RTCRayHit& query) const noexcept;
  [[nodiscard]] bool occludes(const RTCRay& ray) const noexcept;

 private:
  RTCScene group_;
  Motion to_world_;
  std::uint32_t id_;
  std::vector<RTCBounds> boxes_;  // at two evenly spaced times or more; between them, interpolated in float32
};

/// Up to so many are few: from three on, a tree is as fast or faster.
inline constexpr std::size_t kFewMoving = 2;
/// Both for a few.
void intersect(const std::vector<MovingInstance>& instances, RTCRayHit& query) noexcept;
[[nodiscard]] bool occluded(const std::vector<MovingInstance>& instances, const RTCRay& ray) noexcept;

}  // namespace equaltime
