// Spot light: radiant intensity from one point within a cone. Full up to the beam's half angle, then it falls linearly
// with the angle to nothing at the cutoff, as Mitsuba's does.
#pragma once

#include "math/optional.h"
#include "scene/emitter_bounds.h"
#include "scene/light_types.h"

namespace equaltime {

class SpotLight {
 public:
  /// `axis` is unit; `cutoff` and `beam` are half angles in radians, 0 <= beam <= cutoff <= π and 0 < cutoff;
  /// `intensity` is that of the axis.
  SpotLight(const Vec3f& position, const Vec3d& axis, const Spectrum& intensity, double cutoff, double beam) noexcept
      : position_(position), axis_(axis), intensity_(intensity), cutoff_(cutoff), beam_(beam) {}

  /// Nothing outside the cone.
  [[nodiscard]] Optional<LightSample> sample(Vec3f receiver, float pmf) const noexcept;
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] EmitterBounds bounds() const noexcept;

 private:
  /// The share of the axis' intensity that leaves in a direction of any length.
  [[nodiscard]] double falloff(const Vec3d& direction) const noexcept;

  Vec3f position_;
  Vec3d axis_;
  Spectrum intensity_;
  double cutoff_, beam_;
};

}  // namespace equaltime
