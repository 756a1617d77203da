// Directional light: parallel light from infinitely far away, given by the irradiance of a surface that it meets
// head-on.
#pragma once

#include "equaltime/lights/light_types.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

template <class Real>
struct DirectionalLight {
  static constexpr const char* name = "directional";
  Vec3<Real> towards;  // unit, to where the light comes from
  Rgb<Real> irradiance;

  [[nodiscard]] LightSample<Real> sample(Vec3<Real>, Real pmf) const noexcept {
    return {towards, irradiance, pmf, 0, {}, true, true};
  }
  /// What falls on a scene of that radius, as for an environment.
  [[nodiscard]] double power(double scene_radius) const noexcept {
    return static_cast<double>(irradiance.mean()) * std::numbers::pi * square(scene_radius);
  }
};

}  // namespace equaltime
