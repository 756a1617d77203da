// What Embree is given: rays, and boxes that are surely not too small. Only for what stands in this folder.
#pragma once

#include <embree3/rtcore.h>
#include <smmintrin.h>

#include <bit>
#include <cmath>

#include "math/numeric.h"
#include "math/vector.h"

namespace equaltime {

/// Embree takes rays whose origin and direction have no coordinate above 1.844e18; a build with assertions, as Debian's
/// is, ends the process at any other.
inline constexpr float kEmbreeLargest = 1.8e18F;

/// How far from 0 each coordinate of an origin may be; build_scene lets none be below 8192.
class Reach {
 public:
  void limit(float most) noexcept { square_ = _mm_min_ps(square_, _mm_set1_ps(most * most)); }

  /// True if no lane is NaN, or further from 0 than this. A square costs an instruction less than a magnitude.
  [[nodiscard]] bool holds(__m128 lanes) const noexcept {
    const __m128i beyond = _mm_castps_si128(_mm_cmpnle_ps(_mm_mul_ps(lanes, lanes), square_));
    return _mm_testz_si128(beyond, beyond) != 0;
  }

 private:
  __m128 square_ = _mm_set1_ps(kEmbreeLargest * kEmbreeLargest);
};

/// Writes a ray: three 16-byte stores, which is how Embree reads it back; narrower ones would not be forwarded.
inline void write(RTCRay& r, __m128 origin, __m128 direction, float t_max) noexcept {
  _mm_store_ps(&r.org_x, origin);
  _mm_store_ps(&r.dir_x, direction);
  _mm_store_ps(&r.tfar, _mm_setr_ps(t_max, std::bit_cast<float>(~0U), 0.0F, 0.0F));
}

/// Writes a ray whose direction is a unit vector, unless it is NaN or infinite, and tells whether Embree takes it: the
/// sum of origin and direction is within `reach` then, to a rounding. One test of the sum is half of two.
[[nodiscard]] inline bool write_unit(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time,
                                     const Reach& reach) noexcept {
  const __m128 origin = _mm_setr_ps(o.x, o.y, o.z, 0.0F), direction = _mm_setr_ps(d.x, d.y, d.z, time);
  write(r, origin, direction, t_max);
  return reach.holds(_mm_add_ps(origin, direction));
}

/// Writes a ray whose direction may have any length, and tells whether Embree takes it.
[[nodiscard]] inline bool write_any(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time) noexcept {
  const __m128 origin = _mm_setr_ps(o.x, o.y, o.z, 0.0F), direction = _mm_setr_ps(d.x, d.y, d.z, time);
  write(r, origin, direction, t_max);
  const Reach reach;
  return reach.holds(origin) && reach.holds(direction);
}

/// Remembers, until `Accel::refused_ray` asks, that this thread had a ray which Embree does not take.
[[gnu::cold, gnu::noinline]] void refuse_ray() noexcept;

inline float below(double x) noexcept { return std::nextafter(static_cast<float>(x), -kInfinity); }
inline float above(double x) noexcept { return std::nextafter(static_cast<float>(x), kInfinity); }

inline RTCBounds bounds_around(const Vec3d& center, const Vec3d& half) noexcept {
  const Vec3d lo = center - half, hi = center + half;
  return {below(lo.x), below(lo.y), below(lo.z), 0, above(hi.x), above(hi.y), above(hi.z), 0};
}

}  // namespace equaltime
