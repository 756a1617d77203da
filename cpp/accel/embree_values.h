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

/// Writes a ray, and tells whether Embree takes it: no coordinate of its origin and direction may be NaN, or above
/// `reach`, which is no less than any direction's. Written as three 16-byte stores, which is how Embree reads it back:
/// narrower stores would not be forwarded.
[[nodiscard]] inline bool write(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time = 0,
                                float reach = kEmbreeLargest) noexcept {
  const __m128 origin = _mm_setr_ps(o.x, o.y, o.z, 0.0F), direction = _mm_setr_ps(d.x, d.y, d.z, time);
  _mm_store_ps(&r.org_x, origin);
  _mm_store_ps(&r.dir_x, direction);
  _mm_store_ps(&r.tfar, _mm_setr_ps(t_max, std::bit_cast<float>(~0U), 0.0F, 0.0F));
  // Without their signs, floats are in the order of their bits, with NaN above all: a few instructions a ray.
  const __m128i magnitude = _mm_set1_epi32(0x7FFF'FFFF);
  const __m128i largest = _mm_max_epi32(_mm_and_si128(_mm_castps_si128(origin), magnitude),
                                        _mm_and_si128(_mm_castps_si128(direction), magnitude));
  const __m128i beyond = _mm_cmpgt_epi32(largest, _mm_set1_epi32(std::bit_cast<int>(reach)));
  return _mm_testz_si128(beyond, beyond) != 0;
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
