#include "equaltime/lights/cylinder_light.h"

#include <algorithm>
#include <cmath>

#include "equaltime/math/elementary.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/numeric.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

CylinderLight::Strip CylinderLight::facing(const Vec3d& receiver) const noexcept {
  const Vec3d r = receiver - tube_.base;
  const Vec3d across = r - tube_.axis * dot(r, tube_.axis);
  const double distance = length(across);
  if (distance <= tube_.radius) {  // inside: all of the inner side faces it
    const Vec3d any = FrameD::from_normal(tube_.axis).s;
    return {any, inward_ ? std::numbers::pi : 0};
  }
  const double outside = elementary::acos(tube_.radius / distance);
  return inward_ ? Strip{-across / distance, std::numbers::pi - outside} : Strip{across / distance, outside};
}

double CylinderLight::density(const Strip& strip, const Vec3d& to_point, const Vec3d& normal) const noexcept {
  const double distance_squared = length_squared(to_point);
  const double cosine = -dot(normal, to_point) / std::sqrt(distance_squared);
  if (!(cosine > 0) || !(strip.half > 0)) return 0;
  return distance_squared / (cosine * 2 * strip.half * tube_.radius * tube_.length);
}

Optional<LightSample<float>> CylinderLight::sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
  const Vec3d from(receiver);
  const Strip strip = facing(from);
  const auto [sine, cosine] = elementary::sin_cos((2 * static_cast<double>(u.y) - 1) * strip.half);
  const Vec3d out = strip.middle * cosine + cross(tube_.axis, strip.middle) * sine;
  const Vec3d place = tube_.base + tube_.axis * (tube_.length * static_cast<double>(u.x)) + out * tube_.radius;
  const Vec3d normal = inward_ ? -out : out, to_point = place - from;
  const double pdf = density(strip, to_point, normal);
  if (!(pdf > 0)) return std::nullopt;
  const double distance = length(to_point);
  const Vec3f point(place), n(normal);
  return LightSample<float>{.wi = Vec3f(to_point / distance),
                            .radiance = radiance_,
                            .pdf = static_cast<float>(pdf) * pmf,
                            .distance = static_cast<float>(distance),
                            .target = {point, n, point_offset(point, n)}};
}

float CylinderLight::pdf(Vec3f receiver, Vec3f, Vec3f point) const noexcept {
  const Vec3d from(receiver), r = Vec3d(point) - tube_.base;
  const Vec3d out = normalize(r - tube_.axis * dot(r, tube_.axis));
  return static_cast<float>(density(facing(from), Vec3d(point) - from, inward_ ? -out : out));
}

float CylinderLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const Vec3d from(receiver), direction(wi), r = from - tube_.base;
  // Across the axis: where the line enters the tube its outer side faces the receiver, where it leaves, the inner one.
  const Vec3d r_across = r - tube_.axis * dot(r, tube_.axis), along = tube_.axis * dot(direction, tube_.axis);
  const Vec3d d_across = direction - along;
  const double a = length_squared(d_across), middle = -dot(r_across, d_across) / a;
  const double beside = square(tube_.radius) - length_squared(r_across + d_across * middle);
  if (!(beside >= 0)) return 0;
  const double t = middle + (inward_ ? 1 : -1) * std::sqrt(beside / a);
  const double height = dot(r + direction * t, tube_.axis);
  if (!(t > 0 && height >= 0 && height <= tube_.length)) return 0;
  return pdf(receiver, wi, Vec3f(from + direction * t));
}

double CylinderLight::power() const noexcept {
  return 2 * square(std::numbers::pi) * tube_.radius * tube_.length * static_cast<double>(radiance_.mean());
}

LightBounds CylinderLight::bounds() const noexcept {
  const Vec3d& a = tube_.axis;
  const auto reach = [&](double along) {
    return 0.5 * tube_.length * std::abs(along) + tube_.radius * std::sqrt(std::max(0.0, 1 - along * along));
  };
  const Vec3d center = tube_.base + a * (0.5 * tube_.length), half{reach(a.x), reach(a.y), reach(a.z)};
  // It is brightest from the side, where it looks like a rectangle.
  const double brightest = 2 * tube_.radius * tube_.length * static_cast<double>(radiance_.mean());
  return {{center - half, center + half}, elementary::hypot(0.5 * tube_.length, tube_.radius), {}, brightest};
}

CylinderLight CylinderLight::placed(const AffineMap& to) const noexcept {
  const Vec3d axis = to.vector(tube_.axis);
  const double scale = length(axis);
  return {{to.point(tube_.base), axis / scale, tube_.length * scale, tube_.radius * scale}, inward_, radiance_};
}

}  // namespace equaltime
