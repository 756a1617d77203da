// MovingInstance: a group of geometries, placed by a motion, as a geometry of Embree's whose rays this class takes to
// the group's space. Embree's own moving instances turn by fast approximations, which no offset of a ray could bound
// well.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>

#include "math/motion.h"

namespace equaltime {

struct MovingInstance {
  RTCScene group;
  Motion to_world;
  Bounds local;      // of the group, in its own space
  std::uint32_t id;  // what its hits have as instID
  unsigned parts;    // of the shutter: Embree interpolates its box between evenly spaced times
};

/// The instance must stay where it is for as long as the geometry is used.
[[nodiscard]] RTCGeometry new_geometry(RTCDevice device, MovingInstance& instance);

}  // namespace equaltime
