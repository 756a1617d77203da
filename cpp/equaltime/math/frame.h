// Frame: an orthonormal basis whose z axis is a unit normal. Local directions have cosθ = z.
#pragma once

#include "equaltime/math/vector.h"

namespace equaltime {

template <class T>
struct BasicFrame {
  Vec3<T> s, t, n;

  /// Defined for every unit n, without a singular point (Duff et al. 2017, "Building an orthonormal basis, revisited").
  [[nodiscard]] static BasicFrame from_normal(const Vec3<T>& n) noexcept {
    const T sign = copysign(T(1), n.z);
    const T a = T(-1) / (sign + n.z);
    const T b = n.x * n.y * a;
    return {{T(1) + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
  }

  /// s leans towards the tangent, of any length; as from_normal if that lies along n.
  [[nodiscard]] static BasicFrame from_tangent(const Vec3<T>& n, const Vec3<T>& tangent) noexcept {
    const Vec3<T> across = tangent - n * dot(n, tangent);
    const T norm = length(across);
    if (!(norm > 0)) return from_normal(n);
    const Vec3<T> s = across * (T(1) / norm);
    return {s, cross(n, s), n};
  }

  [[nodiscard]] EQUALTIME_INLINE Vec3<T> to_local(const Vec3<T>& v) const noexcept {
    return {dot(v, s), dot(v, t), dot(v, n)};
  }
  [[nodiscard]] EQUALTIME_INLINE Vec3<T> to_world(const Vec3<T>& v) const noexcept {
    return s * v.x + t * v.y + n * v.z;
  }
};

using Frame = BasicFrame<float>;
using FrameD = BasicFrame<double>;

}  // namespace equaltime
