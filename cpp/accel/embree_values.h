// What Embree is given: rays, and boxes that are surely not too small. Only for what stands in this folder.
#pragma once

#include <embree3/rtcore.h>
#include <xmmintrin.h>

#include <bit>
#include <cmath>

#include "math/numeric.h"
#include "math/vector.h"

namespace equaltime {

/// Written as three 16-byte stores, which is how Embree reads it back: narrower stores would not be forwarded.
inline void write(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time = 0) noexcept {
  _mm_store_ps(&r.org_x, _mm_setr_ps(o.x, o.y, o.z, 0.0F));
  _mm_store_ps(&r.dir_x, _mm_setr_ps(d.x, d.y, d.z, time));
  _mm_store_ps(&r.tfar, _mm_setr_ps(t_max, std::bit_cast<float>(~0U), 0.0F, 0.0F));
}

inline float below(double x) noexcept { return std::nextafter(static_cast<float>(x), -kInfinity); }
inline float above(double x) noexcept { return std::nextafter(static_cast<float>(x), kInfinity); }

inline RTCBounds bounds_around(const Vec3d& center, const Vec3d& half) noexcept {
  const Vec3d lo = center - half, hi = center + half;
  return {below(lo.x), below(lo.y), below(lo.z), 0, above(hi.x), above(hi.y), above(hi.z), 0};
}

}  // namespace equaltime
