#include "equaltime/sensors/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "equaltime/math/elementary.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

namespace {

/// Of the geometry's extent: from here, a camera ray's rounding in float64 is 2 % of what it looks at.
constexpr double kFarthest = 0x1p46;
/// Relative to a distance or the extent of the geometry: more than all rounding of a camera ray.
constexpr double kSlack = 16 * static_cast<double>(kUnitRoundoff);

double extent_of(const Bounds& bounds) noexcept { return bounds.empty() ? 0 : max_component(bounds.extent()); }

/// The distance from the camera to the bounds of the geometry, 0 inside them; throws if it is too large.
double distance_to(const Bounds& bounds, const Vec3d& camera) {
  if (bounds.empty()) return 0;
  const double distance = length(max(bounds.lo, min(bounds.hi, camera)) - camera);
  const double extent = extent_of(bounds);
  if (extent > 0 && !(distance <= kFarthest * extent))
    throw std::invalid_argument(
        "the camera is so far from the geometry, for its size, that float64 cannot tell its parts apart");
  return distance;
}

/// The length of the camera's axis in the world; throws if that is nothing, or too much for its direction.
double axis_length(const Transform& to_world) {
  const double found = length(to_world.column(2));
  if (!(found > 0) || !std::isfinite(1 / found) || !std::isfinite(found))
    throw std::invalid_argument("to_world of the sensor makes its axis too short or too long for float64");
  return found;
}

/// A clip in normalised space, whose extent is near 2^10: beyond kFarthestClip all coordinates are rounded away.
double clip(double distance, const char* name) {
  constexpr double kFarthestClip = 0x1p52;
  if (!(distance < kFarthestClip))
    throw std::invalid_argument(std::string(name) + " of the sensor is more than 10^12 times the size of the scene");
  return distance;
}

/// The ray from a distance on, rounded.
Ray rounded(const SensorRay& ray, double start) noexcept {
  const auto& [origin, d, near, far] = ray;
  return {Vec3f(origin + d * start), Vec3f(d), far > 0 ? static_cast<float>(far - start) : kInfinity};
}

}  // namespace

PerspectiveCamera::PerspectiveCamera(const PerspectiveDescription& d, const FilmDescription& film,
                                     const Normalization& normalization, double aperture)
    : origin_(normalization.point(d.to_world.column(3))) {
  const Bounds& bounds = normalization.bounds();
  const double clear = distance_to(bounds, origin_) * (1 - kSlack) - kSlack * extent_of(bounds) - aperture;
  advance_ = std::max(0.0, clear);
  const double half_width = elementary::tan(0.5 * d.x_fov_degrees * std::numbers::pi / 180);
  const double pixel = 2 * half_width / film.width;
  const double x0 = half_width - pixel * film.width * d.principal_point_x;
  const double y0 = pixel * (0.5 * film.height - film.height * d.principal_point_y);
  axis_ = d.to_world.vector({x0, y0, 1});
  right_ = d.to_world.vector({-pixel, 0, 0});
  down_ = d.to_world.vector({0, -pixel, 0});
  // Clips lie along the axis, whose length in this space is that of to_world's third column.
  const double unit = 1 / axis_length(d.to_world);
  if (d.near) near_ = clip(normalization.length(*d.near) * unit, "near_clip");
  if (d.far) far_ = normalization.length(*d.far) * unit;
}

EQUALTIME_INLINE SensorRay PerspectiveCamera::exact(double x, double y) const noexcept {
  const Vec3d along = axis_ + right_ * x + down_ * y;  // reaches one axis length along the axis
  const double norm = length(along);
  return {origin_, along * (1 / norm), near_ * norm, far_ * norm};
}

Ray PerspectiveCamera::ray(double x, double y) const noexcept {
  const SensorRay ray = exact(x, y);
  return rounded(ray, std::max(advance_, ray.near));
}

std::optional<FilmPoint> PerspectiveCamera::place(const Vec3d& axis, const Vec3d& direction) const noexcept {
  const Vec3d across = cross(right_, down_);
  const double reach = dot(axis, across) / dot(direction, across);  // to where a ray of a place on the film is
  if (!(reach > 0 && std::isfinite(reach))) return std::nullopt;
  const Vec3d along = direction * reach, on_film = along - axis;
  const double area = dot(across, across), distance = length(along);
  return FilmPoint{dot(cross(on_film, down_), across) / area, dot(cross(right_, on_film), across) / area,
                   std::abs(dot(along, across)) / (distance * distance * distance)};
}

ThinLensCamera::ThinLensCamera(const ThinLensDescription& d, const FilmDescription& film,
                               const Normalization& normalization)
    : view_(d.view, film, normalization, normalization.length(d.aperture_radius)),
      focus_(normalization.length(d.focus_distance) / length(d.view.to_world.column(2))),
      blades_(d.blades),
      rotation_(static_cast<float>(d.rotation_degrees * std::numbers::pi / 180)) {
  const double radius = normalization.length(d.aperture_radius);
  lens_x_ = d.view.to_world.column(0) * radius;
  lens_y_ = d.view.to_world.column(1) * radius;
}

Vec3d ThinLensCamera::on_lens(Point2f lens) const noexcept {
  const Point2f place = blades_ == 0 ? square_to_disk(lens) : square_to_polygon(lens, blades_, rotation_);
  return lens_x_ * static_cast<double>(place.x) + lens_y_ * static_cast<double>(place.y);
}

EQUALTIME_INLINE SensorRay ThinLensCamera::exact(double x, double y, Point2f lens) const noexcept {
  const auto& [origin, axis, right, down, advance, near, far] = view_;
  const Vec3d from = on_lens(lens);
  // As for a pinhole, but one axis length is divided out of what leads to the plane of focus.
  const Vec3d along = axis + right * x + down * y - from / focus_;
  const double norm = length(along);
  return {origin + from, along * (1 / norm), near * norm, far * norm};
}

Ray ThinLensCamera::ray(double x, double y, Point2f lens) const noexcept {
  const SensorRay ray = exact(x, y, lens);
  return rounded(ray, std::max(view_.advance_, ray.near));
}

OrthographicCamera::OrthographicCamera(const OrthographicDescription& d, const FilmDescription& film,
                                       const Normalization& normalization) {
  const double pixel = 2.0 / film.width;
  const double scale = normalization.length(1);
  corner_ = normalization.point(d.to_world.point({1, 0.5 * pixel * film.height, 0}));
  right_ = d.to_world.vector({-pixel, 0, 0}) * scale;
  down_ = d.to_world.vector({0, -pixel, 0}) * scale;
  const double unit = axis_length(d.to_world);
  direction_ = d.to_world.column(2) / unit;
  const Bounds& bounds = normalization.bounds();
  const Vec3d& to = direction_;
  first_ = bounds.empty() ? corner_
                          : Vec3d{to.x > 0 ? bounds.lo.x : bounds.hi.x, to.y > 0 ? bounds.lo.y : bounds.hi.y,
                                  to.z > 0 ? bounds.lo.z : bounds.hi.z};
  (void)distance_to(bounds, corner_);  // throws
  slack_ = kSlack * extent_of(bounds);
  if (d.near) near_ = clip(*d.near * unit * scale, "near_clip");
  far_ = d.far ? *d.far * unit * scale : static_cast<double>(kInfinity);
}

SensorRay OrthographicCamera::exact(double x, double y) const noexcept {
  return {corner_ + right_ * x + down_ * y, direction_, near_, far_};
}

Ray OrthographicCamera::ray(double x, double y) const noexcept {
  const SensorRay ray = exact(x, y);
  const double clear = dot(first_ - ray.origin, direction_) * (1 - kSlack) - slack_;
  return rounded(ray, std::max(clear, near_));
}

SphericalCamera::SphericalCamera(const SphericalDescription& d, const FilmDescription& film,
                                 const Normalization& normalization)
    : origin_(normalization.point(d.to_world.column(3))),
      x_axis_(normalize(d.to_world.column(0))),
      y_axis_(normalize(d.to_world.column(1))),
      z_axis_(normalize(d.to_world.column(2))),
      azimuth_(2 * std::numbers::pi / film.width),
      polar_(std::numbers::pi / film.height) {
  const Bounds& bounds = normalization.bounds();
  const double clear = distance_to(bounds, origin_) * (1 - kSlack) - kSlack * extent_of(bounds);
  near_ = d.near ? clip(normalization.length(*d.near), "near_clip") : 0.0;
  start_ = std::max({0.0, clear, near_});
  far_ = d.far ? normalization.length(*d.far) : static_cast<double>(kInfinity);
}

SensorRay SphericalCamera::exact(double x, double y) const noexcept {
  const auto [sin_phi, cos_phi] = elementary::sin_cos(azimuth_ * x);
  const auto [sine, cosine] = elementary::sin_cos(polar_ * y);
  return {origin_, x_axis_ * (sin_phi * sine) + y_axis_ * cosine - z_axis_ * (cos_phi * sine), near_, far_};
}

Ray SphericalCamera::ray(double x, double y) const noexcept { return rounded(exact(x, y), start_); }

CameraMotion::CameraMotion(const std::vector<MotionKey>& keys, const Normalization& normalization)
    : to_world_(Motion(keys).between({{}, normalization.length(1)}, normalization.space())),
      bounds_(normalization.bounds()) {
  for (const MotionKey& key : keys) (void)distance_to(bounds_, normalization.point(key.to_world.column(3)));  // throws
}

Ray CameraMotion::ray(const Sensor& sensor, double x, double y, Point2f lens, float time) const noexcept {
  SensorRay ray = std::visit(
      [&](const auto& camera) noexcept {
        if constexpr (requires { camera.exact(x, y, lens); })
          return camera.exact(x, y, lens);
        else
          return camera.exact(x, y);
      },
      sensor);
  const AffineMap now = to_world_.at(static_cast<double>(time));
  ray.origin = now.point(ray.origin);
  const Vec3d along = now.vector(ray.direction);
  const double stretch = length(along);
  ray.direction = along / stretch;
  ray.near *= stretch, ray.far *= stretch;
  double clear = 0;
  if (!bounds_.empty()) {
    const Vec3d nearest = max(bounds_.lo, min(bounds_.hi, ray.origin));
    clear = length(nearest - ray.origin) * (1 - kSlack) - kSlack * extent_of(bounds_);
  }
  // Parallel rays may be clipped before the plane that they start from.
  return rounded(ray, std::max(std::max(0.0, clear), ray.near));
}

}  // namespace equaltime
