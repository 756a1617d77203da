// Uniform sampling of the solid angle of a rectangle (Ureña, Fajardo & King 2013), in float64.
// The solid angle is the argument of one complex product over the corners, with a single arctangent; the inverse needs
// one sine and cosine. The result is uniform in solid angle: its pdf is 1 / solid_angle().
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"
#include "equaltime/math/vector.h"
#include "equaltime/sampling/sampler.h"

namespace equaltime {

class SphericalRectangle {
 public:
  /// `corner` relative to the receiver; `x_axis`, `y_axis` unit and orthogonal; `width`, `height` along them.
  SphericalRectangle(const Vec3d& corner, const Vec3d& x_axis, const Vec3d& y_axis, double width,
                     double height) noexcept
      : x_(x_axis), y_(y_axis), z_(cross(x_axis, y_axis)) {
    z0_ = dot(corner, z_);
    if (z0_ > 0) {
      z_ = -z_;
      z0_ = -z0_;
    }
    x0_ = dot(corner, x_);
    y0_ = dot(corner, y_);
    x1_ = x0_ + width;
    y1_ = y0_ + height;
    solid_angle_ = argument_of_corners();
  }

  [[nodiscard]] double solid_angle() const noexcept { return solid_angle_; }

  /// The point of the rectangle, relative to the receiver, in a direction uniform over the solid angle.
  [[nodiscard]] Vec3d sample(Point2f u) const noexcept {
    const double z_squared = z0_ * z0_;
    // z components of the unit normals of planes through the receiver and an edge (the fourth is not needed).
    const double n0 = -y0_ / std::sqrt(z_squared + y0_ * y0_);
    const double n2 = y1_ / std::sqrt(z_squared + y1_ * y1_);
    const double n3 = -x0_ / std::sqrt(z_squared + x0_ * x0_);
    // Inner angles between planes 2, 3 and 3, 0: only the sine and cosine of their sum are needed.
    const double cos2 = -n2 * n3, cos3 = -n3 * n0;
    const double sin2 = std::sqrt(std::max(0.0, 1 - cos2 * cos2)), sin3 = std::sqrt(std::max(0.0, 1 - cos3 * cos3));
    const double cos_sum = cos2 * cos3 - sin2 * sin3, sin_sum = sin2 * cos3 + cos2 * sin3;
    const double angle = static_cast<double>(u.x) * solid_angle_;
    const auto [sin_angle, cos_angle] = elementary::sin_cos(angle);
    const double sin_au = sin_angle * cos_sum - cos_angle * sin_sum;
    const double cos_au = cos_angle * cos_sum + sin_angle * sin_sum;
    double cu = 0;  // the limit, where the plane of constant u holds the edge
    if (sin_au != 0) {
      const double fu = (cos_au * n0 - n2) / sin_au;
      cu = std::copysign(1 / std::sqrt(fu * fu + n0 * n0), fu);
    }
    cu = std::min(1.0, std::max(-1.0, cu));
    const double xu = std::min(x1_, std::max(x0_, -(cu * z0_) / std::sqrt(std::max(1 - cu * cu, 1e-300))));
    const double d_squared = xu * xu + z_squared;
    const double h0 = y0_ / std::sqrt(d_squared + y0_ * y0_);
    const double h1 = y1_ / std::sqrt(d_squared + y1_ * y1_);
    const double hv = h0 + static_cast<double>(u.y) * (h1 - h0);
    const double rest = 1 - hv * hv;
    const double yv = rest > 0 ? std::min(y1_, std::max(y0_, hv * std::sqrt(d_squared / rest))) : y1_;
    return x_ * xu + y_ * yv + z_ * z0_;
  }

 private:
  /// Sum of the four arctangents of x·y / (|z|·r) with their signs, as the argument of a product: no cancellation of
  /// angles near π, and a result in [0, 2π).
  [[nodiscard]] double argument_of_corners() const noexcept {
    const double z = -z0_;
    double re = 1, im = 0;
    const auto turn = [&](double x, double y, double sign) noexcept {
      const double a = z * std::sqrt(x * x + y * y + z * z), b = sign * x * y;
      const double norm = 1 / std::sqrt(a * a + b * b);
      const double r = (re * a - im * b) * norm;
      im = (re * b + im * a) * norm;
      re = r;
    };
    turn(x1_, y1_, 1);
    turn(x0_, y1_, -1);
    turn(x0_, y0_, 1);
    turn(x1_, y0_, -1);
    const double angle = elementary::atan2(im, re);
    // A negative angle is one above π, but for what rounding makes of 0.
    if (angle < -1e-12) return angle + 2 * std::numbers::pi;
    return std::max(angle, 0.0);
  }

  Vec3d x_, y_, z_;
  double x0_, y0_, x1_, y1_, z0_;
  double solid_angle_;
};

}  // namespace equaltime
