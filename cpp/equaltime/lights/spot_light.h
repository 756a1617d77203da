// Spot light: radiant intensity from one point within a cone. Full up to the beam's half angle, then it falls linearly
// with the angle to nothing at the cutoff, as Mitsuba's does. A texture may multiply it, as a slide in a projector
// does: its unit square is as wide as the cone, on a plane across the axis.
#pragma once

#include <optional>

#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

/// What a spot light projects.
struct ProjectedTexture {
  std::uint32_t texture;
  Vec3d u, v;     // per u and v of the texture: across the axis, unit, times half the cotangent of the cutoff
  Spectrum mean;  // of the texture, roughly, and above 0
};

class SpotLight {
 public:
  static constexpr const char* name = "spot";

  /// `axis` is unit; `cutoff` and `beam` are half angles in radians, 0 <= beam <= cutoff <= π and 0 < cutoff;
  /// `intensity` is that of the axis, but for the slide.
  SpotLight(const Vec3f& position, const Vec3d& axis, const Spectrum& intensity, double cutoff, double beam,
            const std::optional<ProjectedTexture>& slide = {}) noexcept
      : position_(position), axis_(axis), intensity_(intensity), cutoff_(cutoff), beam_(beam), slide_(slide) {}

  /// Nothing outside the cone. Without what the slide does to it.
  [[nodiscard]] Optional<LightSample<float>> sample(Vec3f receiver, float pmf) const noexcept;
  [[nodiscard]] double power(double scene_radius) const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  [[nodiscard]] const std::optional<ProjectedTexture>& slide() const noexcept { return slide_; }
  /// Where the slide is looked up for the light that comes from wi.
  [[nodiscard]] TextureCoords place_on_slide(const Vec3f& wi) const noexcept;

 private:
  /// The share of the axis' intensity that leaves in a direction of any length.
  [[nodiscard]] double falloff(const Vec3d& direction) const noexcept;
  /// Of the axis, with the mean of the slide.
  [[nodiscard]] double mean_intensity() const noexcept {
    return static_cast<double>((slide_ ? intensity_ * slide_->mean : intensity_).mean());
  }

  Vec3f position_;
  Vec3d axis_;
  Spectrum intensity_;
  double cutoff_, beam_;
  std::optional<ProjectedTexture> slide_;
};

}  // namespace equaltime
