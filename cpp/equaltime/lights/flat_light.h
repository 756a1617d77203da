// Flat lights: triangles and rectangles that shine from their front.
// If the receiver is near they sample their solid angle. Further away they sample their area, which costs less and has
// hardly more variance. `is_near` decides, for `sample` and `pdf` alike. Lanes have a light each; what is needed at
// load alone (power, bounds, placed) is compiled for float.
#pragma once

#include <array>
#include <optional>
#include <type_traits>

#include "equaltime/base/optional.h"
#include "equaltime/lights/area_sampling.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/spherical_rectangle.h"
#include "equaltime/sampling/spherical_triangle.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

/// A receiver is near if distance² to the light's centre < kNearSquared · (largest extent)². Beyond 1, the density
/// per solid angle of uniform area points is even enough: on the Cornell box, doubling the range costs 12 % more time
/// for 4 % less variance (tests/bench).
inline constexpr float kNearSquared = 1;

/// A point of a light and the solid angle over which it was drawn uniformly; 0 if it was drawn over the area.
template <class Real>
struct DrawnPoint {
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
  Real area;
  Real offset;        // height below which a receiver counts as a point of the light itself (OffsetPoint)
  Real size_squared;  // size: the largest extent
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
struct SolidAngleSampling {
  /// Nothing if the view is too small for float64: then the area is sampled.
  [[nodiscard]] static std::optional<typename Shape::View> of(const FlatEdges<float>& edges, Vec3f receiver) noexcept;
  /// A point of the light, uniform over the view; `otherwise` if the receiver is not near or there is no view.
  [[nodiscard]] static DrawnPoint<float> sample(bool near, const FlatEdges<float>& edges, Vec3f receiver, Point2f u,
                                                DrawnPoint<float> otherwise) noexcept;
  /// Density of these points; `otherwise` as above.
  [[nodiscard]] static float pdf(bool near, const FlatEdges<float>& edges, Vec3f receiver, float otherwise) noexcept;
};

/// A light on a part of a plane.
template <class Real, class ShapeType>
class FlatLight {
 public:
  using Shape = ShapeType;
  static constexpr const char* name = Shape::name;

  FlatLight(const FlatSurface<Real>& surface, const Rgb<Real>& radiance) noexcept
      : surface_(surface), radiance_(radiance) {}

  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample<Real>> sample(Vec3<Real> receiver, Point2<Real> u,
                                                                    Real pmf) const noexcept {
    const FlatEdges<Real>& edges = surface_.edges;
    const Real height = height_of(receiver);
    const Mask<Real> front = height > surface_.offset;
    if (none(front)) return std::nullopt;
    const auto [a, b] = Shape::uniform(u);
    DrawnPoint<Real> drawn{edges.corner + edges.edge_x * a + edges.edge_y * b, 0};
    if (const Mask<Real> near = is_near(receiver); any(near))
      drawn = for_each_lane<Real>(SolidAngleSampling<Shape>::sample, near, edges, receiver, u, drawn);
    auto sample =
        area_sample(receiver, {drawn.point, surface_.normal, surface_.offset}, height, radiance_, surface_.area, pmf);
    sample.pdf = where(
        drawn.solid_angle > 0, [&] { return pmf / drawn.solid_angle; }, [&] { return sample.pdf; });
    return {sample, front};
  }
  [[nodiscard]] Real pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept;
  [[nodiscard]] Real pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept;
  [[nodiscard]] Mask<Real> faces(Vec3<Real> receiver) const noexcept { return height_of(receiver) > surface_.offset; }
  [[nodiscard]] double power() const noexcept;
  [[nodiscard]] LightBounds bounds() const noexcept;
  /// Returns the light where an instance puts it. A rectangle may become a parallelogram there, so rectangles have no
  /// such function: a template, so that it need not compile for them.
  template <class S = Shape>
  requires std::is_same_v<S, TriangleShape>
  [[nodiscard]] FlatLight placed(const AffineMap& to) const noexcept {
    return {S::placed(surface_.edges, to), radiance_};
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

template <class Real, class Shape>
Real FlatLight<Real, Shape>::pdf(Vec3<Real> receiver, Vec3<Real> wi, Vec3<Real> point) const noexcept {
  const Mask<Real> front = faces(receiver), near = front && is_near(receiver);
  Real pdf = area_pdf(receiver, wi, point, surface_.normal, surface_.area);
  if (any(near)) pdf = for_each_lane<Real>(SolidAngleSampling<Shape>::pdf, near, surface_.edges, receiver, pdf);
  return select(front, pdf, Real(0));
}

template <class Real, class Shape>
Optional<Vec3<Real>> FlatLight<Real, Shape>::met(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const auto& [corner, edge_x, edge_y] = surface_.edges;
  using Vector = Vec3<Double<Real>>;
  const auto hit = plane_towards(receiver, wi, Vector(corner), Vector(edge_x), Vector(edge_y));
  // An empty `hit` holds zeros.
  return {hit->point, hit.has_value() && Shape::contains(hit->a, hit->b)};
}

template <class Real, class Shape>
Real FlatLight<Real, Shape>::pdf_direction(Vec3<Real> receiver, Vec3<Real> wi) const noexcept {
  const auto point = met(receiver, wi);
  return none(point.has_value()) ? Real(0) : select(point.has_value(), pdf(receiver, wi, *point), Real(0));
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
[[nodiscard]] TriangleLight<Real> triangle_light(const Vec3<Real>& v0, const Vec3<Real>& v1, const Vec3<Real>& v2,
                                                 const Rgb<Real>& radiance) noexcept {
  return {triangle_surface(v0, v1, v2), radiance};
}

/// `edge_x` and `edge_y` are orthogonal. Rays meet the rectangle as two triangles with the same corner and edges.
template <class Real>
[[nodiscard]] RectangleLight<Real> rectangle_light(const Vec3<Real>& corner, const Vec3<Double<Real>>& edge_x,
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

extern template class FlatLight<float, TriangleShape>;
extern template class FlatLight<float, RectangleShape>;

}  // namespace equaltime
