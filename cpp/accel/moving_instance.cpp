#include "accel/moving_instance.h"

#include "accel/embree_values.h"

namespace equaltime {

namespace {

void moving_bounds(const RTCBoundsFunctionArguments* args) {
  const MovingInstance& m = *static_cast<const MovingInstance*>(args->geometryUserPtr);
  const double here = static_cast<double>(args->timeStep) / m.parts;
  double off = 0;
  if (args->timeStep > 0) off = m.to_world.deviation(m.local, static_cast<double>(args->timeStep - 1) / m.parts, here);
  if (args->timeStep < m.parts)
    off = std::max(off, m.to_world.deviation(m.local, here, static_cast<double>(args->timeStep + 1) / m.parts));
  const Bounds b = m.to_world.bounds_at(m.local, here);
  // Embree interpolates in float32.
  const double slack = off + 8 * static_cast<double>(kUnitRoundoff) * max_component(max(abs(b.lo), abs(b.hi)));
  *args->bounds_o = bounds_around(b.center(), b.extent() * 0.5 + Vec3d{slack, slack, slack});
}

/// Writes the ray as the group sees it.
void write_local(RTCRay& local, const MovingInstance& m, const RTCRay& r) noexcept {
  const Placement now = m.to_world.at(static_cast<double>(r.time));
  const Vec3d o = now.local_point(Vec3d(Vec3f(r.org_x, r.org_y, r.org_z)));
  const Vec3d d = now.local_vector(Vec3d(Vec3f(r.dir_x, r.dir_y, r.dir_z)));
  write(local, Vec3f(o), Vec3f(d), r.tfar, r.time);
}

void intersect_moving(const RTCIntersectFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const MovingInstance& m = *static_cast<const MovingInstance*>(args->geometryUserPtr);
  auto& query = *reinterpret_cast<RTCRayHit*>(args->rayhit);
  RTCRayHit local;
  write_local(local.ray, m, query.ray);
  local.hit.geomID = local.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(m.group, &context, &local);
  if (local.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  query.ray.tfar = local.ray.tfar;
  query.hit.geomID = local.hit.geomID;
  query.hit.primID = local.hit.primID;
  query.hit.instID[0] = m.id;
}

void occluded_moving(const RTCOccludedFunctionNArguments* args) {
  if (args->valid[0] == 0) return;
  const MovingInstance& m = *static_cast<const MovingInstance*>(args->geometryUserPtr);
  auto& ray = *reinterpret_cast<RTCRay*>(args->ray);
  RTCRay local;
  write_local(local, m, ray);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(m.group, &context, &local);
  if (local.tfar < 0) ray.tfar = -kInfinity;
}

}  // namespace

RTCGeometry new_geometry(RTCDevice device, MovingInstance& instance) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 1);
  rtcSetGeometryTimeStepCount(geometry, instance.parts + 1);
  rtcSetGeometryUserData(geometry, &instance);
  rtcSetGeometryBoundsFunction(geometry, moving_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_moving);
  rtcSetGeometryOccludedFunction(geometry, occluded_moving);
  return geometry;
}

}  // namespace equaltime
