// Lights that are surfaces: triangles, rectangles, spheres, disks.
// Triangles and rectangles sample their solid angle if the receiver is near. Further away they sample their area, which
// costs less and has hardly more variance. `is_near` decides, for `sample` and `pdf` alike. Spheres always sample their
// solid angle, disks their area.
// Lanes have a light each. Functions used at load (power, bounds, placed) are compiled for float alone.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/spherical_rectangle.h"
#include "equaltime/sampling/spherical_triangle.h"
#include "equaltime/sampling/warps.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

/// A flat light is near when its centre is within this many of its largest extents (squared). Beyond one, the density
/// per solid angle of uniform area points is even enough: on the Cornell box, doubling the range costs 12 % more time
/// for 4 % less variance (tests/bench).
inline constexpr float kNearSquared = 1;

/// Light that a one-sided flat light sends from `point` to the receiver, which is `height` above the light's plane.
/// The receiver gets no light if `height` is at most the light's offset, as for points of the light itself.
/// `solid_angle` is the solid angle from which the point was sampled; 0 if it is uniform over `area`.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE LightSample<Real> flat_sample(const Vec3<Real>& receiver, const OffsetPoint<Real>& point,
                                                             Real height, const Rgb<Real>& radiance, Real area,
                                                             Real solid_angle, Real pmf) noexcept {
  const Vec3<Real> to_light = point.p - receiver;
  const Real distance_squared = length_squared(to_light);
  const Real distance = sqrt(distance_squared);
  const Real pdf = where(
      solid_angle > 0, [&] { return pmf / solid_angle; },
      [&] { return pmf * distance_squared * distance / (height * area); });
  return {to_light * (1 / distance), radiance, pdf, distance, point};
}

/// A point of a light and the solid angle over which it was drawn uniformly; 0 if it was drawn over the area.
template <class Real>
struct ViewPoint {
  Vec3<Real> point;
  Real solid_angle;
};

/// The points of a flat light: corner + a·edge_x + b·edge_y. Its shape bounds a and b.
template <class Real>
struct FlatEdges {
  Vec3<Real> corner, edge_x, edge_y;
};

/// A flat light without its radiance: its points, and what follows from them.
template <class Real>
struct FlatSurface {
  FlatEdges<Real> edges;
  Vec3<Real> normal, center;
  Real area, offset, size_squared;  // size: the largest extent
};

/// The shape of a triangle: a, b >= 0 and a + b <= 1.
struct TriangleShape {
  static constexpr const char* name = "triangle";
  using View = SphericalTriangle;

  /// a and b of a point that is uniform over the area.
  template <LaneNumber T>
  [[nodiscard]] EQUALTIME_INLINE static Point2<T> uniform(Point2<T> u) noexcept {
    const T s = sqrt(u.x);
    return {1 - s, s * u.y};
  }
  template <LaneNumber T>
  [[nodiscard]] static auto contains(T a, T b) noexcept {
    return a >= 0 && b >= 0 && a + b <= 1;
  }
  [[nodiscard]] static View view(const FlatEdges<float>& edges, Vec3f receiver) noexcept;
  /// The point of the light that is uniform over the view.
  [[nodiscard]] static Vec3f point(const View& view, const FlatEdges<float>& edges, Vec3f receiver, Point2f u) noexcept;
  [[nodiscard]] static std::array<Vec3d, 3> corners(const FlatEdges<float>& edges) noexcept;
  /// Returns the triangle where an instance puts it.
  [[nodiscard]] static FlatSurface<float> placed(const FlatEdges<float>& edges, const AffineMap& to) noexcept;
};

/// The shape of a rectangle, whose edges are orthogonal: a and b in [0, 1].
struct RectangleShape {
  static constexpr const char* name = "rectangle";
  using View = SphericalRectangle;

  template <LaneNumber T>
  [[nodiscard]] EQUALTIME_INLINE static Point2<T> uniform(Point2<T> u) noexcept {
    return u;
  }
  template <LaneNumber T>
  [[nodiscard]] static auto contains(T a, T b) noexcept {
    return a >= 0 && a <= 1 && b >= 0 && b <= 1;
  }
  [[nodiscard]] static View view(const FlatEdges<float>& edges, Vec3f receiver) noexcept;
  [[nodiscard]] static Vec3f point(const View& view, const FlatEdges<float>& edges, Vec3f receiver, Point2f u) noexcept;
  [[nodiscard]] static std::array<Vec3d, 4> corners(const FlatEdges<float>& edges) noexcept;
};

/// The solid angle of a flat light for one path with a near receiver.
template <class Shape>
struct NearView {
  /// Nothing if the view is too small for float64: then the area is sampled.
  [[nodiscard]] static std::optional<typename Shape::View> of(const FlatEdges<float>& edges, Vec3f receiver) noexcept;
  /// A point of the light, uniform over the view; `otherwise` if the receiver is not near or there is no view.
  [[nodiscard]] static ViewPoint<float> sample(bool near, const FlatEdges<float>& edges, Vec3f receiver, Point2f u,
                                               ViewPoint<float> otherwise) noexcept;
  /// Density of these points; 0 if there is no view.
  [[nodiscard]] static float pdf(const FlatEdges<float>& edges, Vec3f receiver) noexcept;
};

/// A light on a part of a plane.
template <class Real, class ShapeOfLight>
class FlatLight {
 public:
  using Shape = ShapeOfLight;
  static constexpr const char* name = Shape::name;

  FlatLight(const FlatSurface<Real>& surface, const Rgb<Real>& radiance) noexcept
      : surface_(surface), radiance_(radiance) {}

  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample<Real>> sample(Vec3<Real> receiver, Point2<Real> u,
                                                                    Real pmf) const noexcept {
    const auto& [edges, normal, center, area, offset, size_squared] = surface_;
    const Real height = height_of(receiver);
    const Mask<Real> front = height > offset;
    if (none(front)) return std::nullopt;
    const auto [a, b] = Shape::uniform(u);
    ViewPoint<Real> v{edges.corner + edges.edge_x * a + edges.edge_y * b, 0};
    if (Mask<Real> near = is_near(receiver); any(near))
      v = for_each_lane<Real>(NearView<Shape>::sample, near, edges, receiver, u, v);
    return {flat_sample(receiver, {v.point, normal, offset}, height, radiance_, area, v.solid_angle, pmf), front};
  }
  [[nodiscard]] Real pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept;
  [[nodiscard]] Real pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept;
  [[nodiscard]] Mask<Real> faces(Vec3<Real> receiver) const noexcept { return height_of(receiver) > surface_.offset; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it. A rectangle may become a parallelogram there, so rectangles have no
  /// such function.
  [[nodiscard]] FlatLight placed(const AffineMap& to) const noexcept requires std::is_same_v<Shape, TriangleShape> {
    return {Shape::placed(surface_.edges, to), radiance_};
  }

 private:
  template <class Flat>
  friend class TexturedAreaLight;
  /// The point that a direction meets, on either side.
  [[nodiscard]] Optional<Vec3<Real>> met(Vec3<Real> receiver, Vec3<Real> wi) const noexcept;
  [[nodiscard]] Real height_of(const Vec3<Real>& receiver) const noexcept {
    return dot(surface_.normal, receiver - surface_.edges.corner);
  }
  [[nodiscard]] Mask<Real> is_near(Vec3<Real> receiver) const noexcept {
    return length_squared(surface_.center - receiver) < kNearSquared * surface_.size_squared;
  }

  FlatSurface<Real> surface_;
  Rgb<Real> radiance_;
};
template <class Shape>
inline constexpr bool kHasLanes<FlatLight<float, Shape>> = true;

template <class Real>
using TriangleLight = FlatLight<Real, TriangleShape>;
template <class Real>
using RectangleLight = FlatLight<Real, RectangleShape>;

template <class Real>
[[nodiscard]] TriangleLight<Real> triangle_light(const Vec3<Real>& v0, const Vec3<Real>& v1, const Vec3<Real>& v2,
                                                 const Rgb<Real>& radiance) noexcept;
/// `edge_x` and `edge_y` are orthogonal. Rays meet the rectangle as two triangles with the same corner and edges.
template <class Real>
[[nodiscard]] RectangleLight<Real> rectangle_light(const Vec3<Real>& corner, const Vec3<Double<Real>>& edge_x,
                                                   const Vec3<Double<Real>>& edge_y, Mask<Real> flipped,
                                                   const Rgb<Real>& radiance) noexcept;

/// A sampled direction towards a sphere, in a frame whose z axis points to the centre.
template <class Real>
struct SphereDirection {
  Vec3<Double<Real>> local;
  Double<Real> along;  // distance to the sphere in that direction
  Real pdf;
};

template <class Real>
class SphereLight {
 public:
  static constexpr const char* name = "sphere";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  /// `inward`: radiance leaves towards the centre, for a light that encloses its receivers.
  SphereLight(const Vec3<Double<Real>>& center, Double<Real> radius, Mask<Real> inward,
              const Rgb<Real>& radiance) noexcept
      : center_(center), radius_(radius), radiance_(radiance), inward_(inward) {}

  [[nodiscard]] Optional<LightSample<Real>> sample(Vec3<Real> receiver, Point2<Real> u, Real pmf) const noexcept;
  [[nodiscard]] Real pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept;
  [[nodiscard]] Real pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept;
  [[nodiscard]] Mask<Real> faces(Vec3<Real> receiver) const noexcept {
    const Vec3<Double<Real>> to_center = center_ - Vec3<Double<Real>>(receiver);
    return faces(receiver, to_center, length(to_center));
  }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it; the instance scales all directions alike.
  [[nodiscard]] SphereLight placed(const AffineMap& placement) const noexcept;

 private:
  /// Whether a receiver at that distance from the centre is on the side that radiance leaves to.
  [[nodiscard]] Mask<Real> faces(Vec3<Real> receiver, const Vec3<Double<Real>>& to_center,
                                 Double<Real> distance) const noexcept;
  /// From within, any direction; from outside, one of the cone that the sphere fills.
  [[nodiscard]] EQUALTIME_INLINE SphereDirection<Real> draw_within(Point2<Real> u,
                                                                   Double<Real> distance) const noexcept;
  [[nodiscard]] EQUALTIME_INLINE SphereDirection<Real> draw_outside(Point2<Real> u,
                                                                    Double<Real> distance) const noexcept;

  Vec3<Double<Real>> center_;
  Double<Real> radius_;
  Rgb<Real> radiance_;
  Mask<Real> inward_;
};

template <class Real>
class DiskLight {
 public:
  static constexpr const char* name = "disk";
  static constexpr bool Effects::*needs = &Effects::analytic_shapes;

  /// `axis_u`, `axis_v` span the disk: its points are center + a·axis_u + b·axis_v with a² + b² <= 1.
  DiskLight(const Vec3<Double<Real>>& center, const Vec3<Double<Real>>& axis_u, const Vec3<Double<Real>>& axis_v,
            Mask<Real> flipped, const Rgb<Real>& radiance) noexcept;

  [[nodiscard]] Optional<LightSample<Real>> sample(Vec3<Real> receiver, Point2<Real> u, Real pmf) const noexcept;
  [[nodiscard]] Real pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept;
  [[nodiscard]] Real pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept;
  [[nodiscard]] Mask<Real> faces(Vec3<Real> receiver) const noexcept { return height_of(receiver) > offset_; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  [[nodiscard]] DiskLight placed(const AffineMap& placement) const noexcept;

 private:
  [[nodiscard]] Real height_of(const Vec3<Real>& receiver) const noexcept {
    return dot(normal_, receiver - Vec3<Real>(center_));
  }

  Vec3<Double<Real>> center_, axis_u_, axis_v_;
  Vec3<Real> normal_;
  Real area_, offset_;
  Rgb<Real> radiance_;
};

// --- Planes -------------------------------------------------------------------------------------------------------

/// Density per solid angle of the points uniform over an area.
template <class Real>
[[nodiscard]] inline Real solid_angle_pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point,
                                          const Vec3<Real>& normal, Real area) noexcept {
  const Real cosine = -dot(normal, wi);
  return where(cosine > 0, [&] { return length_squared(point - receiver) / (cosine * area); });
}

/// A point of a plane: the plane's origin plus a·edge_u + b·edge_v.
template <class Real>
struct PlanePoint {
  Double<Real> a, b;
  Vec3<Real> point;
};

/// The point in which a direction meets a plane, which its origin and two edges give; none if it lies behind or
/// edge-on.
template <class Real>
[[nodiscard]] inline Optional<PlanePoint<Real>> plane_towards(Vec3<Real> receiver, Vec3<Real> wi,
                                                              const Vec3<Double<Real>>& origin,
                                                              const Vec3<Double<Real>>& edge_u,
                                                              const Vec3<Double<Real>>& edge_v) noexcept {
  const Vec3<Double<Real>> from(receiver), direction(wi), to_receiver = from - origin;
  const Vec3<Double<Real>> across = cross(direction, edge_v), along = cross(to_receiver, edge_u);
  const Double<Real> inverse = 1 / dot(edge_u, across), t = dot(edge_v, along) * inverse;
  const Mask<Real> ahead = t > 0 && t < kInfinity;
  if (none(ahead)) return std::nullopt;
  return {{dot(to_receiver, across) * inverse, dot(direction, along) * inverse, Vec3<Real>(from + direction * t)},
          ahead};
}

// --- Triangles and rectangles -------------------------------------------------------------------------------------

template <class Real, class Shape>
Real FlatLight<Real, Shape>::pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept {
  return where(faces(receiver), [&] {
    const Real in_view =
        where(is_near(receiver), [&] { return for_each_lane<Real>(NearView<Shape>::pdf, surface_.edges, receiver); });
    return where(
        in_view > 0, [&] { return in_view; },
        [&] { return solid_angle_pdf(receiver, wi, point, surface_.normal, surface_.area); });
  });
}

template <class Real, class Shape>
Optional<Vec3<Real>> FlatLight<Real, Shape>::met(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const auto& [corner, edge_x, edge_y] = surface_.edges;
  using Vector = Vec3<Double<Real>>;
  const auto hit = plane_towards(receiver, wi, Vector(corner), Vector(edge_x), Vector(edge_y));
  return {hit->point, hit.has_value() && Shape::contains(hit->a, hit->b)};
}

template <class Real, class Shape>
Real FlatLight<Real, Shape>::pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const auto point = met(receiver, wi);
  return where(point.has_value(), [&] { return pdf(receiver, wi, *point); });
}

template <class Real>
[[nodiscard]] FlatSurface<Real> triangle_surface(const Vec3<Real>& v0, const Vec3<Real>& v1,
                                                 const Vec3<Real>& v2) noexcept {
  const Vec3<Double<Real>> a(v0), b(v1), c(v2), scaled_normal = cross(b - a, c - a);
  const Double<Real> twice_area = length(scaled_normal);
  const Vec3<Real> e1 = v1 - v0, e2 = v2 - v0;
  return {{v0, e1, e2},
          Vec3<Real>(scaled_normal / twice_area),
          v0 + (e1 + e2) * (1.0F / 3.0F),
          Real(0.5 * twice_area),
          triangle_plane(v0, v1, v2).offset,
          max(length_squared(e1), max(length_squared(e2), length_squared(v2 - v1)))};
}

template <class Real>
TriangleLight<Real> triangle_light(const Vec3<Real>& v0, const Vec3<Real>& v1, const Vec3<Real>& v2,
                                   const Rgb<Real>& radiance) noexcept {
  return {triangle_surface(v0, v1, v2), radiance};
}

template <class Real>
RectangleLight<Real> rectangle_light(const Vec3<Real>& corner, const Vec3<Double<Real>>& edge_x,
                                     const Vec3<Double<Real>>& edge_y, Mask<Real> flipped,
                                     const Rgb<Real>& radiance) noexcept {
  const Vec3<Double<Real>> scaled_normal = cross(edge_x, edge_y);
  const Vec3<Real> x(edge_x), y(edge_y);
  const FlatSurface<Real> surface{
      {corner, x, y},
      Vec3<Real>(normalize(scaled_normal) * select(flipped, Double<Real>(-1), Double<Real>(1))),
      corner + (x + y) * 0.5F,
      Real(length(scaled_normal)),
      triangle_plane(corner, corner + x, corner + x + y).offset,
      length_squared(x) + length_squared(y)};
  return {surface, radiance};
}

// --- Sphere -------------------------------------------------------------------------------------------------------

/// 1 - cosθ of the cone that a sphere fills from a distance, without cancellation however small or near it is.
template <LaneNumber T>
[[nodiscard]] inline T one_minus_cos_max(T distance, T radius) noexcept {
  const T inverse = 1 / distance;
  const T cos2 = (distance - radius) * inverse * ((distance + radius) * inverse);
  return square(radius * inverse) / (1 + sqrt(cos2));
}

template <class Real>
Mask<Real> SphereLight<Real>::faces(Vec3<Real> receiver, const Vec3<Double<Real>>& to_center,
                                    Double<Real> distance) const noexcept {
  return where(
      inward_,
      [&] {
        // A receiver on the sphere itself sees the rest of it, on whichever side its rounding may have put it.
        const Vec3<Real> normal(to_center / max(distance, radius_));
        return distance <= radius_ + Double<Real>(point_offset(receiver, normal));
      },
      [&] { return distance > radius_; });
}

template <class Real>
EQUALTIME_INLINE SphereDirection<Real> SphereLight<Real>::draw_within(Point2<Real> u,
                                                                      Double<Real> distance) const noexcept {
  const Vec3<Double<Real>> local(square_to_uniform_sphere(u));
  const Double<Real> b = distance * local.z;
  const Double<Real> half_chord_squared = b * b + (radius_ - distance) * (radius_ + distance);
  return {local, b + sqrt(max(Double<Real>(0), half_chord_squared)), kUniformSpherePdf};
}

template <class Real>
EQUALTIME_INLINE SphereDirection<Real> SphereLight<Real>::draw_outside(Point2<Real> u,
                                                                       Double<Real> distance) const noexcept {
  const Double<Real> range = one_minus_cos_max(distance, radius_);
  const Double<Real> one_minus_cos = Double<Real>(u.x) * range;
  const Double<Real> sin2 = one_minus_cos * (2 - one_minus_cos);
  const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);  // the azimuth alone: float32 is enough
  const Double<Real> sine = sqrt(sin2), cosine = 1 - one_minus_cos;
  const Double<Real> half_chord = sqrt(max(Double<Real>(0), square(radius_) - square(distance) * sin2));
  return {{sine * Double<Real>(cos_phi), sine * Double<Real>(sin_phi), cosine},
          distance * cosine - half_chord,
          Real(1 / (2 * std::numbers::pi * range))};
}

template <class Real>
Optional<LightSample<Real>> SphereLight<Real>::sample(Vec3<Real> receiver, Point2<Real> u, Real pmf) const noexcept {
  const Vec3<Double<Real>> to_center = center_ - Vec3<Double<Real>>(receiver);
  const Double<Real> distance = length(to_center);
  const Mask<Real> front = faces(receiver, to_center, distance);
  if (none(front)) return std::nullopt;
  const SphereDirection<Real> drawn = where(
      inward_, [&] { return draw_within(u, distance); }, [&] { return draw_outside(u, distance); });
  const Mask<Real> met = front && (!inward_ || drawn.along > 0);
  if (none(met)) return std::nullopt;
  const Vec3<Double<Real>> axis = where(
      distance > 0, [&] { return to_center * (1 / distance); },
      [] {
        return Vec3<Double<Real>>{0, 0, 1};
      });
  const Vec3<Double<Real>> direction = BasicFrame<Double<Real>>::from_normal(axis).to_world(drawn.local);
  const Vec3<Double<Real>> outward = normalize(direction * drawn.along - to_center);
  const Double<Real> side = select(inward_, Double<Real>(-1), Double<Real>(1));
  const Vec3<Real> normal(outward * side), point(center_ + outward * radius_);
  return {{Vec3<Real>(direction),
           radiance_,
           drawn.pdf * pmf,
           Real(drawn.along),
           {point, normal, point_offset(point, normal)}},
          met};
}

template <class Real>
Real SphereLight<Real>::pdf(Vec3<Real> receiver, Vec3<Real>, Vec3<Real>) const noexcept {
  const Vec3<Double<Real>> to_center = center_ - Vec3<Double<Real>>(receiver);
  const Double<Real> distance = length(to_center);
  return where(faces(receiver, to_center, distance), [&] {
    return where(
        inward_, [] { return Real(kUniformSpherePdf); },
        [&] { return Real(1 / (2 * std::numbers::pi * one_minus_cos_max(distance, radius_))); });
  });
}

template <class Real>
Real SphereLight<Real>::pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const Vec3<Double<Real>> to_center = center_ - Vec3<Double<Real>>(receiver), direction(wi);
  const Mask<Real> met =
      dot(to_center, direction) > 0 && length_squared(cross(to_center, direction)) <= square(radius_);
  return where(inward_ || met, [&] { return pdf(receiver, wi, {}); });
}

// --- Disk ---------------------------------------------------------------------------------------------------------

template <class Real>
DiskLight<Real>::DiskLight(const Vec3<Double<Real>>& center, const Vec3<Double<Real>>& axis_u,
                           const Vec3<Double<Real>>& axis_v, Mask<Real> flipped, const Rgb<Real>& radiance) noexcept
    : center_(center), axis_u_(axis_u), axis_v_(axis_v), radiance_(radiance) {
  const Vec3<Double<Real>> scaled_normal = cross(axis_u, axis_v);
  area_ = Real(std::numbers::pi * length(scaled_normal));
  normal_ = Vec3<Real>(normalize(scaled_normal) * select(flipped, Double<Real>(-1), Double<Real>(1)));
  const Vec3<Real> furthest(abs(center) + abs(axis_u) + abs(axis_v));
  offset_ = point_offset(furthest, normal_);
}

template <class Real>
Optional<LightSample<Real>> DiskLight<Real>::sample(Vec3<Real> receiver, Point2<Real> u, Real pmf) const noexcept {
  const Real height = height_of(receiver);
  const Mask<Real> front = height > offset_;
  if (none(front)) return std::nullopt;
  const Point2<Real> d = square_to_disk(u);
  const Vec3<Real> point(center_ + axis_u_ * Double<Real>(d.x) + axis_v_ * Double<Real>(d.y));
  return {flat_sample(receiver, {point, normal_, offset_}, height, radiance_, area_, Real(0), pmf), front};
}

template <class Real>
Real DiskLight<Real>::pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept {
  return where(faces(receiver), [&] { return solid_angle_pdf(receiver, wi, point, normal_, area_); });
}

template <class Real>
Real DiskLight<Real>::pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const auto hit = plane_towards(receiver, wi, center_, axis_u_, axis_v_);
  return where(hit.has_value() && square(hit->a) + square(hit->b) <= 1, [&] { return pdf(receiver, wi, hit->point); });
}

extern template class FlatLight<float, TriangleShape>;
extern template class FlatLight<float, RectangleShape>;
extern template class SphereLight<float>;
extern template class DiskLight<float>;

}  // namespace equaltime
