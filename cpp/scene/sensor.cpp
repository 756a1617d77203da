#include "scene/sensor.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace equaltime {

namespace {

/// Of the geometry's extent: from here, a camera ray's rounding in float64 is 2 % of what it looks at.
constexpr double kFarthest = 0x1p46;

/// A little less than the distance from the camera to the bounds of the geometry; 0 inside them.
double clear_distance(const Bounds& bounds, const Vec3d& camera) noexcept {
  if (bounds.empty()) return 0;
  const Vec3d nearest = max(bounds.lo, min(bounds.hi, camera));
  return length(nearest - camera) * (1 - 16 * static_cast<double>(kUnitRoundoff)) -
         16 * static_cast<double>(kUnitRoundoff) * max_component(bounds.extent());
}

}  // namespace

PerspectiveCamera::PerspectiveCamera(const PerspectiveDescription& d, const FilmDescription& film,
                                     const Normalization& normalization)
    : origin_(normalization.point(d.to_world.column(3))) {
  advance_ = std::max(0.0, clear_distance(normalization.bounds(), origin_));
  const double extent = normalization.bounds().empty() ? 0 : max_component(normalization.bounds().extent());
  if (extent > 0 && !(advance_ <= kFarthest * extent))
    throw std::invalid_argument(
        "the camera is so far from the geometry, for its size, that float64 cannot tell its parts apart");
  const double half_width = std::tan(0.5 * d.x_fov_degrees * std::numbers::pi / 180);
  const double pixel = 2 * half_width / film.width;
  const double x0 = half_width - pixel * film.width * d.principal_point_x;
  const double y0 = pixel * (0.5 * film.height - film.height * d.principal_point_y);
  axis_ = d.to_world.vector({x0, y0, 1});
  right_ = d.to_world.vector({-pixel, 0, 0});
  down_ = d.to_world.vector({0, -pixel, 0});
  // Clips lie along the axis, whose length in this space is that of to_world's third column.
  const double unit = 1 / length(d.to_world.column(2));
  if (d.near) near_ = normalization.length(*d.near) * unit;
  if (d.far) far_ = normalization.length(*d.far) * unit;
}

Ray PerspectiveCamera::ray(double x, double y) const noexcept {
  const Vec3d along = axis_ + right_ * x + down_ * y;  // reaches one axis length along the axis
  const double norm = length(along);
  const Vec3d d = along * (1 / norm);
  const double start = std::max(advance_, near_ * norm);
  return {Vec3f(origin_ + d * start), Vec3f(d), far_ > 0 ? static_cast<float>(far_ * norm - start) : kInfinity};
}

}  // namespace equaltime
