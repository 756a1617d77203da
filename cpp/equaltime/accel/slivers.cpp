#include "equaltime/accel/slivers.h"

#include <algorithm>
#include <array>

#include "equaltime/accel/packet_lanes.h"
#include "equaltime/math/ray.h"

namespace equaltime {

namespace {

using Corners = std::array<Vec3d, 3>;

/// Height over the rounding of corners from which on triangles are met where they are, but for 6 rays in 10^5 of those
/// aimed along their line; of a height of one rounding it is 1 in 100.
constexpr double kThick = 0x1p8;
/// How far from a triangle, in roundings of it and of the ray's origin, Embree may meet its edges.
constexpr double kPassedBy = 16;

Corners corners_of(const TriangleMesh& mesh, std::uint32_t primitive) noexcept {
  const auto& [a, b, c] = mesh.triangles[primitive];
  return {Vec3d(mesh.vertices[a]), Vec3d(mesh.vertices[b]), Vec3d(mesh.vertices[c])};
}

double reach(const Corners& v) noexcept {
  return max_component(max(abs(v[0]), max(abs(v[1]), abs(v[2])))) * static_cast<double>(kUnitRoundoff);
}

bool is_sliver(const Corners& v) noexcept {
  const double longest =
      std::max({length_squared(v[1] - v[0]), length_squared(v[2] - v[1]), length_squared(v[0] - v[2])});
  const double thick = kThick * reach(v);
  return length_squared(cross(v[1] - v[0], v[2] - v[0])) < thick * thick * longest;
}

/// The squared distance between a segment and the line through the origin along the unit vector. Both are projected
/// along the line, which leaves a point and a segment in a plane.
double distance_squared(const Vec3d& along, const Vec3d& from, const Vec3d& to) noexcept {
  const Vec3d a = from - along * dot(along, from), edge = to - from, e = edge - along * dot(along, edge);
  const double size = length_squared(e);
  return length_squared(a + e * (size > 0 ? std::clamp(-dot(a, e) / size, 0.0, 1.0) : 0.0));
}

/// Whether the ray's line comes so close to the triangle that rounding may make it a hit.
bool comes_near(const Corners& v, const RayD& ray) noexcept {
  const Vec3d d = normalize(ray.direction);
  const Corners seen = {v[0] - ray.origin, v[1] - ray.origin, v[2] - ray.origin};
  double volumes[3], nearest = HUGE_VAL;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    volumes[i] = dot(d, cross(seen[i], seen[next]));
    nearest = std::min(nearest, distance_squared(d, seen[i], seen[next]));
  }
  const auto [least, most] = std::minmax({volumes[0], volumes[1], volumes[2]});
  const double origin = max_component(abs(ray.origin)) * static_cast<double>(kUnitRoundoff);
  return least >= 0 || most <= 0 || nearest <= square(kPassedBy * (reach(v) + origin));
}

void filter(const RTCFilterFunctionNArguments* args) {
  const auto& slivers = *static_cast<const Slivers*>(args->geometryUserPtr);
  for_each_valid_lane(args->valid, args->N, [&](unsigned count, unsigned lane) noexcept {
    const std::uint32_t primitive = RTCHitN_primID(args->hit, count, lane);
    if (slivers.thin[primitive] &&
        !comes_near(corners_of(*slivers.mesh, primitive), RayD(ray_of(args->ray, count, lane))))
      args->valid[lane] = 0;
  });
}

}  // namespace

Slivers slivers_of(const TriangleMesh& mesh) {
  Slivers slivers{&mesh, {}};
  if (!mesh.later.empty()) return slivers;
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!is_sliver(corners_of(mesh, i))) continue;
    slivers.thin.resize(count);
    slivers.thin[i] = true;
  }
  return slivers;
}

void drop_false_hits(RTCGeometry geometry, Slivers& slivers) noexcept {
  rtcSetGeometryUserData(geometry, &slivers);
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
}

}  // namespace equaltime
