// Disk light: shines from its front. Sampled uniformly over its area, for one path at a time.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/point.h"

namespace equaltime {

class DiskLight {
 public:
  static constexpr const char* name = "disk";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  /// `axis_u`, `axis_v` span the disk: its points are center + a·axis_u + b·axis_v with a² + b² <= 1.
  DiskLight(const Vec3d& center, const Vec3d& axis_u, const Vec3d& axis_v, bool flipped,
            const Spectrum& radiance) noexcept;

  [[nodiscard]] Optional<LightSample<float>> sample(Vec3f receiver, Point2f u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return height_of(receiver) > offset_; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it.
  [[nodiscard]] DiskLight placed(const AffineMap& to) const noexcept;

 private:
  [[nodiscard]] float height_of(Vec3f receiver) const noexcept { return dot(normal_, receiver - Vec3f(center_)); }

  Vec3d center_, axis_u_, axis_v_;
  Vec3f normal_;
  float area_, offset_;
  Spectrum radiance_;
};

}  // namespace equaltime
