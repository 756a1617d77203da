// Ray: points origin + t·direction for t in (0, t_max). Its direction is unit where it looks for the nearest surface;
// between two points it is their difference and t_max is 1.
#pragma once

#include "equaltime/math/numeric.h"
#include "equaltime/math/vector.h"

namespace equaltime {

struct Ray {
  Vec3f origin;
  Vec3f direction;
  float t_max = kInfinity;
};

/// The same in float64: where exactly a surface is met.
struct RayD {
  RayD(const Vec3d& o, const Vec3d& d, double most) noexcept : origin(o), direction(d), t_max(most) {}
  explicit RayD(const Ray& ray) noexcept
      : origin(ray.origin), direction(ray.direction), t_max(static_cast<double>(ray.t_max)) {}

  Vec3d origin, direction;
  double t_max;
};

}  // namespace equaltime
