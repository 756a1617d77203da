// Sphere light: it shines outwards, or inwards around its receivers. A receiver outside samples the directions of the
// cone that the sphere fills; a receiver within samples all directions. In float64, for one path at a time.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/point.h"

namespace equaltime {

class SphereLight {
 public:
  static constexpr const char* name = "sphere";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  SphereLight(const Vec3d& center, double radius, bool inward, const Spectrum& radiance) noexcept
      : center_(center), radius_(radius), radiance_(radiance), inward_(inward) {}

  [[nodiscard]] Optional<LightSample<float>> sample(Vec3f receiver, Point2f u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept;
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it; the instance scales all directions alike.
  [[nodiscard]] SphereLight placed(const AffineMap& to) const noexcept;

 private:
  /// A direction towards the sphere, in a frame whose z axis points to the centre.
  struct Direction {
    Vec3d local;
    double along;  // distance to the sphere in that direction
    float pdf;
  };
  /// Whether a receiver at that distance from the centre is on the side that radiance leaves to.
  [[nodiscard]] bool faces(Vec3f receiver, const Vec3d& to_center, double distance) const noexcept;
  [[nodiscard]] Direction sample_all_directions(Point2f u, double distance) const noexcept;
  [[nodiscard]] Direction sample_cone(Point2f u, double distance) const noexcept;
  /// 1 - cosθ of the cone, without cancellation however small or near the sphere is.
  [[nodiscard]] double one_minus_cos_max(double distance) const noexcept;

  Vec3d center_;
  double radius_;
  Spectrum radiance_;
  bool inward_;
};

}  // namespace equaltime
