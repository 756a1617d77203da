// Lights that are surfaces: triangles, rectangles, spheres, disks.
// Near a light its solid angle is sampled; further away, where the two hardly differ in variance, its area, which costs
// less. One function of shape and receiver decides which, for `sample` and `pdf` alike.
#pragma once

#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/lights/emitter_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/spherical_rectangle.h"
#include "equaltime/sampling/spherical_triangle.h"

namespace equaltime {

/// A flat light is near when its centre is within this many of its largest extents (squared). Beyond one, the density
/// per solid angle of uniform area points is even enough: on the Cornell box, doubling the range costs 12 % more time
/// for 4 % less variance (tests/bench).
inline constexpr float kNearSquared = 1;

/// What a one-sided flat light sends from `point` to the receiver, which lies at `height` above its plane: more than
/// the light's offset, since one within the plane, such as a point of the light itself, sees nothing of it.
/// `solid_angle` is that of the view that was sampled, or 0 if the point is uniform over `area`.
[[nodiscard]] EQUALTIME_INLINE LightSample flat_sample(const Vec3f& receiver, const OffsetPoint& point, float height,
                                                       const Spectrum& radiance, float area, float solid_angle,
                                                       float pmf) noexcept {
  const Vec3f to_light = point.p - receiver;
  const float distance_squared = length_squared(to_light);
  const float distance = std::sqrt(distance_squared);
  const float pdf = solid_angle > 0 ? pmf / solid_angle : pmf * distance_squared * distance / (height * area);
  return {to_light * (1 / distance), radiance, pdf, distance, point};
}

/// A point of a light and the solid angle over which it was drawn uniformly; 0 if it was drawn over the area.
struct ViewPoint {
  Vec3f point;
  float solid_angle;
};

class TriangleLight {
 public:
  static constexpr const char* name = "triangle";

  TriangleLight(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, const Spectrum& radiance) noexcept;

  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample> sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
    const float height = height_of(receiver);
    if (!(height > offset_)) return std::nullopt;
    const float s = std::sqrt(u.x);
    ViewPoint v{v0_ + e1_ * (1 - s) + e2_ * (s * u.y), 0};
    if (is_near(receiver)) v = sample_view(receiver, u, v);
    return flat_sample(receiver, {v.point, normal_, offset_}, height, radiance_, area_, v.solid_angle, pmf);
  }
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return height_of(receiver) > offset_; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] EmitterBounds bounds() const noexcept;
  /// The same light, taken to where an instance puts it.
  [[nodiscard]] TriangleLight placed(const AffineMap& placement) const noexcept;

 private:
  template <class Flat>
  friend class TexturedAreaLight;
  using View = SphericalTriangle;
  /// The point that a direction meets, on either side.
  [[nodiscard]] std::optional<Vec3f> met(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] float height_of(const Vec3f& receiver) const noexcept { return dot(normal_, receiver - v0_); }
  [[nodiscard]] bool is_near(Vec3f receiver) const noexcept {
    return length_squared(center_ - receiver) < kNearSquared * size_squared_;
  }
  /// The view of the triangle from a near receiver; nothing if it is too small for float64, and the area is sampled.
  [[nodiscard]] std::optional<View> near_view(Vec3f receiver) const noexcept;
  /// A point of the triangle, uniform over the view.
  [[nodiscard]] Vec3f point_in(const View& view, Vec3f receiver, Point2f u) const noexcept;
  [[nodiscard]] ViewPoint sample_view(Vec3f receiver, Point2f u, ViewPoint otherwise) const noexcept;

  Vec3f v0_, e1_, e2_, normal_, center_;
  float area_, offset_, size_squared_;
  Spectrum radiance_;
};

class RectangleLight {
 public:
  static constexpr const char* name = "rectangle";

  /// `corner` and the edges are those of the two triangles that rays meet; the edges are orthogonal.
  RectangleLight(const Vec3f& corner, const Vec3d& edge_x, const Vec3d& edge_y, bool flipped,
                 const Spectrum& radiance) noexcept;

  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample> sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
    const float height = height_of(receiver);
    if (!(height > offset_)) return std::nullopt;
    ViewPoint v{corner_ + edge_x_ * u.x + edge_y_ * u.y, 0};
    if (is_near(receiver)) v = sample_view(receiver, u, v);
    return flat_sample(receiver, {v.point, normal_, offset_}, height, radiance_, area_, v.solid_angle, pmf);
  }
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return height_of(receiver) > offset_; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] EmitterBounds bounds() const noexcept;

 private:
  template <class Flat>
  friend class TexturedAreaLight;
  using View = SphericalRectangle;
  /// The point that a direction meets, on either side.
  [[nodiscard]] std::optional<Vec3f> met(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] float height_of(const Vec3f& receiver) const noexcept { return dot(normal_, receiver - corner_); }
  [[nodiscard]] bool is_near(Vec3f receiver) const noexcept {
    return length_squared(center_ - receiver) < kNearSquared * size_squared_;
  }
  [[nodiscard]] std::optional<View> near_view(Vec3f receiver) const noexcept;
  /// A point of the rectangle, uniform over the view.
  [[nodiscard]] Vec3f point_in(const View& view, Vec3f receiver, Point2f u) const noexcept;
  [[nodiscard]] ViewPoint sample_view(Vec3f receiver, Point2f u, ViewPoint otherwise) const noexcept;

  Vec3f corner_, edge_x_, edge_y_, normal_, center_;
  float area_, offset_, size_squared_;
  Spectrum radiance_;
};

class SphereLight {
 public:
  static constexpr const char* name = "sphere";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  /// `inward`: radiance leaves towards the centre, for a light that encloses its receivers.
  SphereLight(const Vec3d& center, double radius, bool inward, const Spectrum& radiance) noexcept
      : center_(center), radius_(radius), radiance_(radiance), inward_(inward) {}

  [[nodiscard]] Optional<LightSample> sample(Vec3f receiver, Point2f u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept {
    const Vec3d to_center = center_ - Vec3d(receiver);
    return faces(receiver, to_center, length(to_center));
  }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] EmitterBounds bounds() const noexcept;
  /// The same light, taken to where an instance puts it that scales all directions alike.
  [[nodiscard]] SphereLight placed(const AffineMap& placement) const noexcept;

 private:
  /// Whether a receiver at that distance from the centre is on the side that radiance leaves to.
  [[nodiscard]] bool faces(Vec3f receiver, const Vec3d& to_center, double distance) const noexcept;

  Vec3d center_;
  double radius_;
  Spectrum radiance_;
  bool inward_;
};

class DiskLight {
 public:
  static constexpr const char* name = "disk";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  /// `axis_u`, `axis_v` span the disk: its points are center + a·axis_u + b·axis_v with a² + b² <= 1.
  DiskLight(const Vec3d& center, const Vec3d& axis_u, const Vec3d& axis_v, bool flipped,
            const Spectrum& radiance) noexcept;

  [[nodiscard]] Optional<LightSample> sample(Vec3f receiver, Point2f u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return height_of(receiver) > offset_; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] EmitterBounds bounds() const noexcept;
  [[nodiscard]] DiskLight placed(const AffineMap& placement) const noexcept;

 private:
  [[nodiscard]] float height_of(const Vec3f& receiver) const noexcept {
    return dot(normal_, receiver - Vec3f(center_));
  }

  Vec3d center_, axis_u_, axis_v_;
  Vec3f normal_;
  float area_, offset_;
  Spectrum radiance_;
};

}  // namespace equaltime
