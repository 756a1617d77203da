// Uniform sampling of the solid angle of a triangle (Arvo 1995), in float64, with the solid angle from edge
// differences. Vertices are given relative to the receiver; the result is uniform in solid angle: its pdf is 1 /
// solid_angle().
#pragma once

#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"
#include "equaltime/math/vector.h"
#include "equaltime/sampling/sampler.h"

namespace equaltime {

class SphericalTriangle {
 public:
  /// `v0` relative to the receiver; `e1`, `e2` the edges v1 - v0 and v2 - v0, from the vertices themselves: forming
  /// them from rounded differences to a distant receiver would lose a small triangle.
  SphericalTriangle(const Vec3d& v0, const Vec3d& e1, const Vec3d& e2) noexcept
      : a_(normalize(v0)), b_(normalize(v0 + e1)), c_(normalize(v0 + e2)) {
    const Vec3d v1 = v0 + e1;
    const Vec3d v2 = v0 + e2;
    const double la = length(v0), lb = length(v1), lc = length(v2);
    // Van Oosterom & Strackee 1983; the triple product is taken with the edges.
    const double numerator = std::abs(dot(v0, cross(e1, e2)));
    const double denominator = la * lb * lc + dot(v0, v1) * lc + dot(v0, v2) * lb + dot(v1, v2) * la;
    solid_angle_ = 2 * elementary::atan2(numerator, denominator);
  }

  [[nodiscard]] double solid_angle() const noexcept { return solid_angle_; }

  /// Unit direction from the receiver, uniform over the solid angle.
  [[nodiscard]] Vec3d sample(Point2f u) const noexcept {
    const Vec3d n_ab = cross(a_, b_);
    const Vec3d n_ac = cross(a_, c_);
    const double norm = 1 / std::sqrt(length_squared(n_ab) * length_squared(n_ac));
    const double cos_alpha = dot(n_ab, n_ac) * norm;
    const double sin_alpha = length(cross(n_ab, n_ac)) * norm;
    // Arvo's cos b, reordered so that nothing cancels: next to a triangle that covers half the world, sin alpha is next
    // to 0, and c_sub, next to the antipode of b, must be right to a small part of that.
    const double one_minus_cos_c = 0.5 * length_squared(a_ - b_);
    const double area = static_cast<double>(u.x) * solid_angle_;
    const double sin_half = elementary::sin(0.5 * area), one_minus_cos_area = 2 * sin_half * sin_half;
    const double s = elementary::sin(area) * cos_alpha - (1 - one_minus_cos_area) * sin_alpha;  // of area - alpha
    const double denominator = one_minus_cos_area - one_minus_cos_c * s * sin_alpha;
    const double numerator = (2 - one_minus_cos_c) * one_minus_cos_area;
    const double one_minus_cos_b = denominator > 0 ? std::fmin(2.0, numerator / denominator) : 0.0;
    const Vec3d c_sub = along_arc(a_, c_, 1 - one_minus_cos_b, one_minus_cos_b);
    const Vec3d chord = c_sub - b_;
    const double one_minus_cos = static_cast<double>(u.y) * 0.5 * length_squared(chord);
    return along_arc(b_, c_sub, 1 - one_minus_cos, one_minus_cos);
  }

 private:
  /// The unit vector at the angle of given cosine from `from` on the great arc towards `to`.
  static Vec3d along_arc(const Vec3d& from, const Vec3d& to, double cosine, double one_minus_cosine) noexcept {
    const Vec3d away = (to - from) - from * dot(from, to - from);
    const double norm = length(away);
    if (!(norm > 0)) return from;
    const double sine = std::sqrt(std::fmax(0.0, one_minus_cosine * (1 + cosine)));
    return from * cosine + away * (sine / norm);
  }

  Vec3d a_, b_, c_;
  double solid_angle_;
};

}  // namespace equaltime
