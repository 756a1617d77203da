#include "equaltime/accel/moving_instance.h"

#include <algorithm>

#include "equaltime/accel/packet_lanes.h"

namespace equaltime {

namespace {

/// The box at one end of parts of the shutter: what is within moves evenly but for what a part strays from that.
RTCBounds box_at(const Motion& to_world, const Bounds& local, unsigned step, unsigned parts) noexcept {
  const double here = static_cast<double>(step) / parts;
  double off = 0;
  if (step > 0) off = to_world.deviation(local, static_cast<double>(step - 1) / parts, here);
  if (step < parts) off = std::max(off, to_world.deviation(local, here, static_cast<double>(step + 1) / parts));
  const Bounds b = to_world.bounds_at(local, here);
  // Interpolation is in float32.
  const double slack = off + 8 * static_cast<double>(kUnitRoundoff) * max_component(max(abs(b.lo), abs(b.hi)));
  const Vec3d half = b.extent() * 0.5 + Vec3d{slack, slack, slack};
  return rounded({b.center() - half, b.center() + half});
}

/// Writes the ray as the group sees it, and tells whether Embree takes it.
bool write_local(RTCRay& local, const Motion& to_world, const RTCRay& r) noexcept {
  const AffineMap now = to_world.at(static_cast<double>(r.time));
  const Vec3d o = now.local_point(Vec3d(Vec3f(r.org_x, r.org_y, r.org_z)));
  const Vec3d d = now.local_vector(Vec3d(Vec3f(r.dir_x, r.dir_y, r.dir_z)));
  return write_any(local, Vec3f(o), Vec3f(d), r.tfar, r.time);
}

Float4 inverse_direction(const RTCRay& r) noexcept { return 1 / load(&r.dir_x); }

void intersect_callback(const RTCIntersectFunctionNArguments* args) {
  const auto& instance = *static_cast<const MovingInstance*>(args->geometryUserPtr);
  for_each_valid_lane(args->valid, args->N, [&](unsigned count, unsigned lane) noexcept {
    RTCRayHit query = rtcGetRayHitFromRayHitN(args->rayhit, count, lane);
    args->valid[lane] = instance.intersect(query) ? -1 : 0;
    if (args->valid[lane] != 0)
      put_hit(args->rayhit, count, lane, query.ray.tfar, query.hit.instID[0], query.hit.geomID, query.hit.primID);
  });
}

void occluded_callback(const RTCOccludedFunctionNArguments* args) {
  const auto& instance = *static_cast<const MovingInstance*>(args->geometryUserPtr);
  for_each_valid_lane(args->valid, args->N, [&](unsigned count, unsigned lane) noexcept {
    args->valid[lane] = instance.occludes(rtcGetRayFromRayN(args->ray, count, lane)) ? -1 : 0;
    if (args->valid[lane] != 0) RTCRayN_tfar(args->ray, count, lane) = -kInfinity;
  });
}

}  // namespace

MovingInstance::MovingInstance(RTCScene group, const Motion& to_world, std::uint32_t id)
    : group_(group), to_world_(to_world), id_(id) {
  RTCBounds b;
  rtcGetSceneBounds(group, &b);
  Bounds local;
  local.include(Vec3d(Vec3f(b.lower_x, b.lower_y, b.lower_z)));
  local.include(Vec3d(Vec3f(b.upper_x, b.upper_y, b.upper_z)));
  const unsigned parts = to_world.parts(local);
  for (unsigned step = 0; step <= parts; ++step) boxes_.push_back(box_at(to_world, local, step, parts));
}

RTCGeometry MovingInstance::new_geometry(RTCDevice device) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(boxes_.size()));
  rtcSetGeometryUserData(geometry, this);
  const auto bounds = [](const RTCBoundsFunctionArguments* args) {
    *args->bounds_o = static_cast<const MovingInstance*>(args->geometryUserPtr)->boxes_[args->timeStep];
  };
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_callback);
  rtcSetGeometryOccludedFunction(geometry, occluded_callback);
  return geometry;
}

/// What comes of 0 times infinity is all the same: such a ray runs along a side of the box, which nothing in it
/// touches.
EQUALTIME_INLINE bool MovingInstance::near(const RTCRay& r, Float4 inverse) const noexcept {
  const float time = r.time * static_cast<float>(boxes_.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(time), boxes_.size() - 2);
  const RTCBounds &a = boxes_[i], &b = boxes_[i + 1];
  const float f = time - static_cast<float>(i);
  const Float4 lo = load(&a.lower_x) * (1 - f) + load(&b.lower_x) * f;
  const Float4 hi = load(&a.upper_x) * (1 - f) + load(&b.upper_x) * f;
  const Float4 origin = load(&r.org_x), low = (lo - origin) * inverse, high = (hi - origin) * inverse;
  const Float4 first = low < high ? low : high, last = low > high ? low : high;
  const float enters = std::max(0.0F, std::max(first[0], std::max(first[1], first[2])));
  const float leaves = std::min(r.tfar, std::min(last[0], std::min(last[1], last[2])));
  constexpr float kMore = 1 + 16 * kUnitRoundoff;
  return enters <= leaves * kMore;
}

bool MovingInstance::intersect(RTCRayHit& query) const noexcept {
  RTCRayHit local;
  if (!write_local(local.ray, to_world_, query.ray)) {
    refuse_ray();
    return false;
  }
  local.hit.geomID = local.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree_intersect(group_, local);
  if (local.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  query.ray.tfar = local.ray.tfar;
  query.hit.geomID = local.hit.geomID;
  query.hit.primID = local.hit.primID;
  query.hit.instID[0] = id_;
  return true;
}

bool MovingInstance::occludes(const RTCRay& ray) const noexcept {
  RTCRay local;
  if (!write_local(local, to_world_, ray)) {
    refuse_ray();
    return true;
  }
  embree_occluded(group_, local);
  return local.tfar < 0;
}

void intersect(const std::vector<MovingInstance>& instances, RTCRayHit& query) noexcept {
  const Float4 inverse = inverse_direction(query.ray);
  for (const MovingInstance& instance : instances)
    if (instance.near(query.ray, inverse)) instance.intersect(query);
}

bool occluded(const std::vector<MovingInstance>& instances, const RTCRay& ray) noexcept {
  const Float4 inverse = inverse_direction(ray);
  return std::any_of(instances.begin(), instances.end(), [&](const MovingInstance& instance) {
    return instance.near(ray, inverse) && instance.occludes(ray);
  });
}

}  // namespace equaltime
