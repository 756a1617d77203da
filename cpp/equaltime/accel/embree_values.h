// What Embree is given: rays, and boxes that are surely not too small. Only for what stands in this folder.
#pragma once

#ifdef __SSE4_1__
#include <smmintrin.h>
#endif

#include <bit>
#include <cmath>

#include "equaltime/accel/embree.h"
#include "equaltime/math/bounds.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/vector.h"

namespace equaltime {

/// Embree takes rays whose origin and direction have no coordinate above 1.844e18; a build with assertions, as Debian's
/// is, ends the process at any other.
inline constexpr float kEmbreeLargest = 1.8e18F;

/// Four numbers side by side, as they lie in Embree's structs: what GCC and Clang have for any processor.
using Float4 = float __attribute__((vector_size(16), may_alias));

inline Float4 load(const float* aligned) noexcept { return *reinterpret_cast<const Float4*>(aligned); }
inline void store(float* aligned, Float4 lanes) noexcept { *reinterpret_cast<Float4*>(aligned) = lanes; }

/// How far from 0 each coordinate of an origin may be; build_scene lets none be below 8192.
class Reach {
 public:
  void limit(float most) noexcept {
    const Float4 square = most * most + Float4{};
    square_ = square_ < square ? square_ : square;
  }

  /// True if no lane is NaN, or further from 0 than this. A square costs an instruction less than a magnitude.
  [[nodiscard]] bool holds(Float4 lanes) const noexcept {
#ifdef __SSE4_1__
    const __m128i beyond = _mm_castps_si128(_mm_cmpnle_ps(lanes * lanes, square_));
    return _mm_testz_si128(beyond, beyond) != 0;
#else
    const auto within = lanes * lanes <= square_;
    return (within[0] & within[1] & within[2] & within[3]) != 0;
#endif
  }

 private:
  Float4 square_ = kEmbreeLargest * kEmbreeLargest + Float4{};
};

/// Writes a ray: three 16-byte stores, which is how Embree reads it back; narrower ones would not be forwarded.
inline void write(RTCRay& r, Float4 origin, Float4 direction, float t_max) noexcept {
  store(&r.org_x, origin);
  store(&r.dir_x, direction);
  store(&r.tfar, Float4{t_max, std::bit_cast<float>(~0U), 0.0F, 0.0F});
}

/// Writes a ray whose direction is a unit vector, unless it is NaN or infinite, and tells whether Embree takes it: the
/// sum of origin and direction is within `reach` then, to a rounding. One test of the sum is half of two.
[[nodiscard]] inline bool write_unit(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time,
                                     const Reach& reach) noexcept {
  const Float4 origin{o.x, o.y, o.z, 0.0F}, direction{d.x, d.y, d.z, time};
  write(r, origin, direction, t_max);
  return reach.holds(origin + direction);
}

/// Writes a ray whose direction may have any length, and tells whether Embree takes it.
[[nodiscard]] inline bool write_any(RTCRay& r, Vec3f o, Vec3f d, float t_max, float time) noexcept {
  const Float4 origin{o.x, o.y, o.z, 0.0F}, direction{d.x, d.y, d.z, time};
  write(r, origin, direction, t_max);
  const Reach reach;
  return reach.holds(origin) && reach.holds(direction);
}

/// Remembers, until `Accel::take_refusal` asks, that this thread had a ray which Embree does not take.
[[gnu::cold, gnu::noinline]] void refuse_ray() noexcept;

inline float rounded_down(double x) noexcept { return std::nextafter(static_cast<float>(x), -kInfinity); }
inline float rounded_up(double x) noexcept { return std::nextafter(static_cast<float>(x), kInfinity); }

/// A box in float32 that holds the given one.
inline RTCBounds rounded(const Bounds& box) noexcept {
  const auto& [lo, hi] = box;
  return {rounded_down(lo.x), rounded_down(lo.y), rounded_down(lo.z), 0,
          rounded_up(hi.x),   rounded_up(hi.y),   rounded_up(hi.z),   0};
}

}  // namespace equaltime
