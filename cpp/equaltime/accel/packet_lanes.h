// Lanes of the packets that Embree hands to its callbacks; a single ray is a packet of one lane. Only for this folder.
#pragma once

#include "equaltime/accel/embree.h"
#include "equaltime/math/ray.h"

namespace equaltime {

/// Calls f(count, lane) for each lane of a packet that is valid. A single ray is a packet of one lane, whose numbers
/// are constants to f where it is inlined.
template <class F>
EQUALTIME_INLINE void for_each_valid_lane(const int* valid, unsigned count, const F& f) noexcept {
  if (count == 1) {
    if (valid[0] != 0) f(1U, 0U);
    return;
  }
  for (unsigned lane = 0; lane < count; ++lane)
    if (valid[lane] != 0) f(count, lane);
}

EQUALTIME_INLINE Ray ray_of(RTCRayN* rays, unsigned count, unsigned lane) noexcept {
  return {{RTCRayN_org_x(rays, count, lane), RTCRayN_org_y(rays, count, lane), RTCRayN_org_z(rays, count, lane)},
          {RTCRayN_dir_x(rays, count, lane), RTCRayN_dir_y(rays, count, lane), RTCRayN_dir_z(rays, count, lane)},
          RTCRayN_tfar(rays, count, lane)};
}

/// Puts a hit into a lane: a primitive of a geometry in an instance, at t.
EQUALTIME_INLINE void put_hit(RTCRayHitN* query, unsigned count, unsigned lane, float t, unsigned instance,
                              unsigned geometry, unsigned primitive) noexcept {
  RTCHitN* hit = RTCRayHitN_HitN(query, count);
  RTCRayN_tfar(RTCRayHitN_RayN(query, count), count, lane) = t;
  RTCHitN_geomID(hit, count, lane) = geometry;
  RTCHitN_primID(hit, count, lane) = primitive;
  RTCHitN_instID(hit, count, lane, 0) = instance;
}

}  // namespace equaltime
