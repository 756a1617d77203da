// Cylinder light: a tube without caps that shines outwards, or inwards. Sampled by area, over the strip of it that
// faces the receiver.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/motion.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

class CylinderLight {
 public:
  static constexpr const char* name = "cylinder";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  CylinderLight(const Cylinder<float>& tube, bool inward, const Spectrum& radiance) noexcept
      : tube_(tube), radiance_(radiance), inward_(inward) {}

  [[nodiscard]] Optional<LightSample<float>> sample(Vec3f receiver, Point2f u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return facing(Vec3d(receiver)).half > 0; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it; the instance scales all directions alike.
  [[nodiscard]] CylinderLight placed(const AffineMap& to) const noexcept;

 private:
  /// The part of the tube whose front faces a receiver: within `half` of an angle round the axis.
  struct Strip {
    Vec3d middle;  // unit, across the axis
    double half;   // radians, 0 to π; 0: none
  };
  [[nodiscard]] Strip facing(const Vec3d& receiver) const noexcept;
  /// Density per solid angle of points uniform in a strip; 0 if the point's front does not face the receiver.
  [[nodiscard]] double density(const Strip& strip, const Vec3d& to_point, const Vec3d& normal) const noexcept;

  Cylinder<float> tube_;
  Spectrum radiance_;
  bool inward_;
};

}  // namespace equaltime
