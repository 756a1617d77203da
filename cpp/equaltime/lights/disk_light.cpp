#include "equaltime/lights/disk_light.h"

#include <cmath>

#include "equaltime/lights/area_sampling.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/warps.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

DiskLight::DiskLight(const Vec3d& center, const Vec3d& axis_u, const Vec3d& axis_v, bool flipped,
                     const Spectrum& radiance) noexcept
    : center_(center), axis_u_(axis_u), axis_v_(axis_v), radiance_(radiance) {
  const Vec3d scaled_normal = cross(axis_u, axis_v), unit = normalize(scaled_normal);
  area_ = static_cast<float>(std::numbers::pi * length(scaled_normal));
  normal_ = Vec3f(flipped ? -unit : unit);
  offset_ = point_offset(Vec3f(abs(center) + abs(axis_u) + abs(axis_v)), normal_);  // of the furthest point
}

Optional<LightSample<float>> DiskLight::sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
  const float height = height_of(receiver);
  if (!(height > offset_)) return std::nullopt;
  const Point2f d = square_to_disk(u);
  const Vec3f point(center_ + axis_u_ * static_cast<double>(d.x) + axis_v_ * static_cast<double>(d.y));
  return area_sample(receiver, {point, normal_, offset_}, height, radiance_, area_, pmf);
}

float DiskLight::pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept {
  return faces(receiver) ? area_pdf(receiver, wi, point, normal_, area_) : 0;
}

float DiskLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const auto hit = plane_towards(receiver, wi, center_, axis_u_, axis_v_);
  return hit && square(hit->a) + square(hit->b) <= 1 ? pdf(receiver, wi, hit->point) : 0;
}

double DiskLight::power() const noexcept { return emitted_power(radiance_, static_cast<double>(area_)); }

LightBounds DiskLight::bounds() const noexcept {
  const Vec3d &u = axis_u_, &v = axis_v_;
  const Vec3d half{elementary::hypot(u.x, v.x), elementary::hypot(u.y, v.y), elementary::hypot(u.z, v.z)};
  const double uu = length_squared(u), vv = length_squared(v), uv = dot(u, v);
  const double semi_major_squared = 0.5 * (uu + vv + elementary::hypot(uu - vv, 2 * uv));  // of the ellipse
  return {{center_ - half, center_ + half},
          std::sqrt(semi_major_squared),
          {Vec3d(normal_), 0},
          power() * std::numbers::inv_pi};
}

DiskLight DiskLight::placed(const AffineMap& to) const noexcept {
  const bool flipped = dot(cross(axis_u_, axis_v_), Vec3d(normal_)) < 0;
  return {to.point(center_), to.vector(axis_u_), to.vector(axis_v_), flipped != to.mirrors(), radiance_};
}

}  // namespace equaltime
