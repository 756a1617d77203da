// Point light: radiant intensity from one point, alike in all directions.
#pragma once

#include "equaltime/lights/emitter_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

struct PointLight {
  Vec3f position;
  Spectrum intensity;

  [[nodiscard]] LightSample sample(Vec3f receiver, float pmf) const noexcept {
    const Vec3f to_light = position - receiver;
    const float distance = length(to_light);
    const float inv = 1 / distance;
    const Vec3f wi = to_light * inv;
    return {wi, intensity * (inv * inv), pmf, distance, {position, -wi, 0}, false, true};
  }
  [[nodiscard]] double power() const noexcept { return 4 * std::numbers::pi * static_cast<double>(intensity.mean()); }
  [[nodiscard]] EmitterBounds bounds() const noexcept {
    return {{Vec3d(position), Vec3d(position)}, 0, {}, static_cast<double>(intensity.mean())};
  }
};

}  // namespace equaltime
