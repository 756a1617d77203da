// Point light: radiant intensity from one point, alike in all directions.
#pragma once

#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

template <class Real>
struct PointLight {
  static constexpr const char* name = "point";
  Vec3<Real> position;
  Rgb<Real> intensity;

  [[nodiscard]] LightSample<Real> sample(Vec3<Real> receiver, Real pmf) const noexcept {
    const Vec3<Real> to_light = position - receiver;
    const Real distance = length(to_light);
    const Real inv = 1 / distance;
    const Vec3<Real> wi = to_light * inv;
    return {wi, intensity * (inv * inv), pmf, distance, {position, -wi, 0}, false, true};
  }
  [[nodiscard]] double power(double) const noexcept {
    return 4 * std::numbers::pi * static_cast<double>(intensity.mean());
  }
  [[nodiscard]] LightBounds bounds() const noexcept {
    return {{Vec3d(position), Vec3d(position)}, 0, {}, static_cast<double>(intensity.mean())};
  }
};

}  // namespace equaltime
