#include "equaltime/math/normalization.h"

#include <cmath>

namespace equaltime {

namespace {

/// The exponent e with 2^(e-1) <= x < 2^e.
int exponent_of(double x) noexcept {
  int e = 0;
  std::frexp(x, &e);
  return e;
}

Spectrum scaled(const Vec3d& v, double s) noexcept {
  return {static_cast<float>(v.x * s), static_cast<float>(v.y * s), static_cast<float>(v.z * s)};
}

}  // namespace

Normalization::Normalization(const Vec3d& origin, const Bounds& world) : origin_(origin) {
  const double extent = world.empty() ? 0 : max_component(world.extent());
  if (extent > 0) length_scale_ = std::ldexp(1.0, kExtentExponent - exponent_of(extent));
  if (!world.empty()) {
    bounds_.include(point(world.lo));
    bounds_.include(point(world.hi));
  }
}

void Normalization::fit_radiance(double most) noexcept {
  if (most > 0) radiance_scale_ = std::ldexp(1.0, -exponent_of(most));
}

Spectrum Normalization::radiance(const Vec3d& world) const noexcept { return scaled(world, radiance_scale_); }
Spectrum Normalization::intensity(const Vec3d& world) const noexcept {
  return scaled(world, radiance_scale_ * length_scale_ * length_scale_);
}

}  // namespace equaltime
