#include "equaltime/scene/recompute_hit.h"

#include <numbers>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// Azimuth of (x, y), in turns from 0 to 1.
double azimuth(double x, double y) noexcept {
  const double turns = elementary::atan2(y, x) * (0.5 * std::numbers::inv_pi);
  return turns < 0 ? turns + 1 : turns;
}

}  // namespace

namespace detail {

Point2f uv_at(const Sphere<float>&, const ShapeParametrization& s, ShapeHit<float> hit) noexcept {
  const Vec3f n(hit.n);
  const auto x = static_cast<double>(dot(s.azimuth[0], n)), y = static_cast<double>(dot(s.azimuth[1], n));
  const double polar = elementary::atan2(elementary::hypot(x, y), static_cast<double>(dot(s.pole, n)));
  return {static_cast<float>(azimuth(x, y)), static_cast<float>(polar * std::numbers::inv_pi)};
}

Point2f uv_at(const Disk<float>& disk, const ShapeParametrization&, ShapeHit<float> hit) noexcept {
  const Vec3d r = hit.p - disk.center;
  const double x = dot(disk.inv_u, r), y = dot(disk.inv_v, r);
  return {static_cast<float>(elementary::hypot(x, y)), static_cast<float>(azimuth(x, y))};
}

Point2f uv_at(const Cylinder<float>& cylinder, const ShapeParametrization& s, CylinderHit<float> hit) noexcept {
  const Vec3f n(hit.hit.n);
  const auto x = static_cast<double>(dot(s.azimuth[0], n)), y = static_cast<double>(dot(s.azimuth[1], n));
  return {static_cast<float>(azimuth(x, y)), static_cast<float>(hit.height / cylinder.length)};
}

}  // namespace detail

}  // namespace equaltime
