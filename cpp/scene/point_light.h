// Point light: radiant intensity from one point, alike in all directions.
#pragma once

#include "math/numeric.h"
#include "scene/light_types.h"

namespace equaltime {

struct PointLight {
  Vec3f position;
  Spectrum intensity;

  [[nodiscard]] LightSample sample(Vec3f receiver) const noexcept {
    const Vec3f to_light = position - receiver;
    const float inv = 1 / length(to_light);
    const Vec3f wi = to_light * inv;
    return {wi, intensity * (inv * inv), 1, {position, -wi, 0}, false, true};
  }
  [[nodiscard]] double power() const noexcept { return 4 * std::numbers::pi * static_cast<double>(intensity.mean()); }
};

}  // namespace equaltime
