// Normalization: the space in which everything is intersected and shaded.
// The camera (clamped to the geometry's bounds) is moved to the origin, where float32 is finest, and lengths are scaled
// by a power of two to an extent near 2^10, so that no absolute size ever meets float32's range or Embree's. Radiance
// is scaled by a power of two as well. Both are exact: scaling a scene by a power of two changes no bit of its image.
#pragma once

#include "equaltime/math/bounds.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/spectrum.h"

namespace equaltime {

class Normalization {
 public:
  Normalization() = default;
  /// The space with this origin, scaled so that the bounds of the geometry have an extent near 2^10.
  Normalization(const Vec3d& origin, const Bounds& world);
  /// Returns a camera's own space: it has the scale of this one, and no geometry.
  [[nodiscard]] Normalization of_camera() const noexcept {
    Normalization own;
    own.length_scale_ = length_scale_, own.radiance_scale_ = radiance_scale_;
    return own;
  }
  /// For motions between spaces.
  [[nodiscard]] Motion::Space space() const noexcept { return {origin_, length_scale_}; }

  [[nodiscard]] Vec3d point(const Vec3d& world) const noexcept { return (world - origin_) * length_scale_; }
  [[nodiscard]] double length(double world) const noexcept { return world * length_scale_; }
  [[nodiscard]] Vec3d world_point(const Vec3d& p) const noexcept { return p / length_scale_ + origin_; }
  [[nodiscard]] double world_length(double l) const noexcept { return l / length_scale_; }
  [[nodiscard]] Spectrum radiance(const Vec3d& world) const noexcept;
  [[nodiscard]] Spectrum intensity(const Vec3d& world) const noexcept;
  /// Factor from normalised radiance back to the user's.
  [[nodiscard]] double world_radiance_scale() const noexcept { return 1 / radiance_scale_; }
  [[nodiscard]] double radiance_scale() const noexcept { return radiance_scale_; }
  /// Takes the largest radiance that anything sends, in the user's units, below 1.
  void fit_radiance(double most) noexcept;
  /// The power of two near which the largest extent is.
  static constexpr int kExtentExponent = 10;
  /// Bounds of the geometry, in normalised space; empty without geometry.
  [[nodiscard]] const Bounds& bounds() const noexcept { return bounds_; }

 private:
  Vec3d origin_{};
  double length_scale_ = 1;
  double radiance_scale_ = 1;
  Bounds bounds_;
};

}  // namespace equaltime
