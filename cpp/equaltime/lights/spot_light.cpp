#include "equaltime/lights/spot_light.h"

#include <algorithm>
#include <cmath>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

double SpotLight::falloff(const Vec3d& direction) const noexcept {
  const double angle = elementary::atan2(length(cross(axis_, direction)), dot(axis_, direction));
  if (angle <= beam_) return 1;
  return angle < cutoff_ ? (cutoff_ - angle) / (cutoff_ - beam_) : 0;
}

Optional<LightSample<float>> SpotLight::sample(Vec3f receiver, float pmf) const noexcept {
  const Vec3f to_light = position_ - receiver;
  const double share = falloff(-Vec3d(to_light));
  if (!(share > 0)) return std::nullopt;
  const float distance = length(to_light);
  const float inv = 1 / distance;
  const Vec3f wi = to_light * inv;
  return LightSample<float>{
      wi, intensity_ * (static_cast<float>(share) * inv * inv), pmf, distance, {position_, -wi, 0}, false, true,
  };
}

TextureCoords SpotLight::place_on_slide(const Vec3f& wi) const noexcept {
  const Vec3d away = -Vec3d(wi);
  const double along = dot(away, axis_);
  return {
      {static_cast<float>(0.5 + dot(away, slide_->u) / along), static_cast<float>(0.5 + dot(away, slide_->v) / along)}};
}

/// ∫ falloff dω = 2π(1 - (sin c - sin b) / (c - b)), as a sum of what is never negative.
double SpotLight::power(double) const noexcept {
  const double middle = 0.5 * (cutoff_ + beam_), half = 0.5 * (cutoff_ - beam_);
  const double sinc = half > 0 ? std::min(1.0, elementary::sin(half) / half) : 1.0;
  const double share = 2 * square(elementary::sin(0.5 * middle)) * sinc + (1 - sinc);
  return 2 * std::numbers::pi * mean_intensity() * share;
}

LightBounds SpotLight::bounds() const noexcept {
  const Vec3d p(position_);
  return {{p, p}, 0, {axis_, cutoff_}, mean_intensity()};
}

}  // namespace equaltime
