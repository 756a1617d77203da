#include "equaltime/lights/sphere_light.h"

#include <algorithm>
#include <cmath>

#include "equaltime/lights/area_sampling.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/warps.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

namespace {

/// Density of the directions that are uniform in a cone.
float cone_pdf(double one_minus_cos_max) noexcept {
  return static_cast<float>(1 / (2 * std::numbers::pi * one_minus_cos_max));
}

}  // namespace

bool SphereLight::faces(Vec3f receiver, const Vec3d& to_center, double distance) const noexcept {
  if (!inward_) return distance > radius_;
  // A receiver on the sphere itself sees the rest of it, on whichever side its rounding may have put it.
  const Vec3f normal(to_center / std::max(distance, radius_));
  return distance <= radius_ + static_cast<double>(point_offset(receiver, normal));
}

bool SphereLight::faces(Vec3f receiver) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver);
  return faces(receiver, to_center, length(to_center));
}

double SphereLight::one_minus_cos_max(double distance) const noexcept {
  const double inverse = 1 / distance;
  const double cos2 = (distance - radius_) * inverse * ((distance + radius_) * inverse);
  return square(radius_ * inverse) / (1 + std::sqrt(cos2));
}

SphereLight::Direction SphereLight::sample_all_directions(Point2f u, double distance) const noexcept {
  const Vec3d local(square_to_uniform_sphere(u));
  const double b = distance * local.z;
  const double half_chord_squared = b * b + (radius_ - distance) * (radius_ + distance);
  return {local, b + std::sqrt(std::max(0.0, half_chord_squared)), kUniformSpherePdf};
}

SphereLight::Direction SphereLight::sample_cone(Point2f u, double distance) const noexcept {
  const double range = one_minus_cos_max(distance), one_minus_cos = static_cast<double>(u.x) * range;
  const double sin2 = one_minus_cos * (2 - one_minus_cos);
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);  // the azimuth alone: float32 is enough
  const double sine = std::sqrt(sin2), cosine = 1 - one_minus_cos;
  const double half_chord = std::sqrt(std::max(0.0, square(radius_) - square(distance) * sin2));
  return {{sine * static_cast<double>(cos_phi), sine * static_cast<double>(sin_phi), cosine},
          distance * cosine - half_chord,
          cone_pdf(range)};
}

Optional<LightSample<float>> SphereLight::sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver);
  const double distance = length(to_center);
  if (!faces(receiver, to_center, distance)) return std::nullopt;
  const Direction drawn = inward_ ? sample_all_directions(u, distance) : sample_cone(u, distance);
  if (inward_ && !(drawn.along > 0)) return std::nullopt;
  const Vec3d axis = distance > 0 ? to_center * (1 / distance) : Vec3d{0, 0, 1};
  const Vec3d direction = FrameD::from_normal(axis).to_world(drawn.local);
  const Vec3d outward = normalize(direction * drawn.along - to_center);
  const Vec3f normal(inward_ ? -outward : outward), point(center_ + outward * radius_);
  return LightSample<float>{.wi = Vec3f(direction),
                            .radiance = radiance_,
                            .pdf = drawn.pdf * pmf,
                            .distance = static_cast<float>(drawn.along),
                            .target = {point, normal, point_offset(point, normal)}};
}

float SphereLight::pdf(Vec3f receiver, Vec3f, Vec3f) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver);
  const double distance = length(to_center);
  if (!faces(receiver, to_center, distance)) return 0;
  if (inward_) return kUniformSpherePdf;
  return cone_pdf(one_minus_cos_max(distance));
}

float SphereLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver), direction(wi);
  const bool met = dot(to_center, direction) > 0 && length_squared(cross(to_center, direction)) <= square(radius_);
  return inward_ || met ? pdf(receiver, wi, {}) : 0;
}

double SphereLight::power() const noexcept { return emitted_power(radiance_, 4 * std::numbers::pi * square(radius_)); }

LightBounds SphereLight::bounds() const noexcept {
  const Vec3d half{radius_, radius_, radius_};
  return {{center_ - half, center_ + half}, radius_, {}, power() * 0.25 * std::numbers::inv_pi};
}

SphereLight SphereLight::placed(const AffineMap& to) const noexcept {
  return {to.point(center_), radius_ * length(to.columns[0]), inward_, radiance_};
}

}  // namespace equaltime
