// Ray: points origin + t·direction for t in (0, t_max). Its direction is unit where it looks for the nearest surface;
// between two points it is their difference and t_max is 1.
#pragma once

#include "equaltime/math/numeric.h"
#include "equaltime/math/vector.h"

namespace equaltime {

template <class Real>
struct BasicRay {
  Vec3<Real> origin;
  Vec3<Real> direction;
  Real t_max = kInfinity;
};
using Ray = BasicRay<float>;

/// The same in float64: where exactly a surface is met.
template <class Real>
struct BasicRayD {
  BasicRayD(const Vec3<Double<Real>>& o, const Vec3<Double<Real>>& d, Double<Real> most) noexcept
      : origin(o), direction(d), t_max(most) {}
  explicit BasicRayD(const BasicRay<Real>& ray) noexcept
      : origin(ray.origin), direction(ray.direction), t_max(Double<Real>(ray.t_max)) {}

  Vec3<Double<Real>> origin, direction;
  Double<Real> t_max;
};
using RayD = BasicRayD<float>;

}  // namespace equaltime
