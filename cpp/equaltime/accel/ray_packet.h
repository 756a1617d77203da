// RayPacket: up to eight rays that Embree traces at once. Only for this folder.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "equaltime/accel/embree_values.h"
#include "equaltime/math/ray.h"

namespace equaltime {

class RayPacket {
 public:
  static constexpr std::size_t kLanes = 8;

  /// The first rays and their times; a ray beyond `reach` is refused.
  RayPacket(std::span<const Ray> rays, std::span<const float> times, const Reach& reach) noexcept
      : size_(std::min(kLanes, rays.size())) {
    for (std::size_t i = 0; i < size_; ++i) {
      RTCRayHit query;
      const auto& [o, d, t_max] = rays[i];
      valid_[i] = write_unit(query.ray, o, d, t_max, times[i], reach) ? -1 : 0;
      if (valid_[i] == 0) refuse_ray();
      put(i, query.ray);
    }
  }

  void intersect(RTCScene scene) noexcept { embree_intersect(valid_.data(), scene, query_); }
  void occlude(RTCScene scene) noexcept { embree_occluded(valid_.data(), scene, query_.ray); }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// Whether Embree took the ray.
  [[nodiscard]] bool accepted(std::size_t i) const noexcept { return valid_[i] != 0; }
  [[nodiscard]] RTCRayHit lane(std::size_t i) noexcept {
    return rtcGetRayHitFromRayHitN(reinterpret_cast<RTCRayHitN*>(&query_), kLanes, static_cast<unsigned>(i));
  }

 private:
  void put(std::size_t i, const RTCRay& ray) noexcept {
    RTCRay8& r = query_.ray;
    r.org_x[i] = ray.org_x, r.org_y[i] = ray.org_y, r.org_z[i] = ray.org_z, r.tnear[i] = ray.tnear;
    r.dir_x[i] = ray.dir_x, r.dir_y[i] = ray.dir_y, r.dir_z[i] = ray.dir_z, r.time[i] = ray.time;
    r.tfar[i] = ray.tfar, r.mask[i] = ray.mask, r.id[i] = ray.id, r.flags[i] = ray.flags;
    query_.hit.geomID[i] = query_.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }

  std::size_t size_;
  alignas(32) std::array<int, kLanes> valid_{};
  RTCRayHit8 query_;
};

}  // namespace equaltime
