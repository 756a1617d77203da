#include "equaltime/lights/flat_light.h"

#include <algorithm>
#include <span>

namespace equaltime {

namespace {

/// Below this solid angle the sampling of a spherical polygon has lost digits that float64 cannot spare.
constexpr double kSmallestView = 1e-8;

/// Bounds with the box of the corners, and the distance of the furthest corner from its middle.
LightBounds flat_bounds(std::span<const Vec3d> corners, const Vec3f& normal, double power) noexcept {
  LightBounds bounds{{}, 0, {Vec3d(normal), 0}, power * std::numbers::inv_pi};
  for (const Vec3d& p : corners) bounds.box.include(p);
  for (const Vec3d& p : corners) bounds.radius = std::max(bounds.radius, length(p - bounds.box.center()));
  return bounds;
}

}  // namespace

// --- Shapes -------------------------------------------------------------------------------------------------------

SphericalTriangle TriangleShape::view(const FlatEdges<float>& edges, Vec3f receiver) noexcept {
  return {Vec3d(edges.corner) - Vec3d(receiver), Vec3d(edges.edge_x), Vec3d(edges.edge_y)};
}

Vec3f TriangleShape::point(const View& view, const FlatEdges<float>& edges, Vec3f receiver, Point2f u) noexcept {
  const Vec3d direction = view.sample(u);
  const Vec3d normal = cross(Vec3d(edges.edge_x), Vec3d(edges.edge_y)), from(receiver);
  const double t = dot(normal, Vec3d(edges.corner) - from) / dot(normal, direction);
  return Vec3f(from + direction * t);
}

std::array<Vec3d, 3> TriangleShape::corners(const FlatEdges<float>& edges) noexcept {
  const Vec3d v0(edges.corner);
  return {v0, v0 + Vec3d(edges.edge_x), v0 + Vec3d(edges.edge_y)};
}

FlatSurface<float> TriangleShape::placed(const FlatEdges<float>& edges, const AffineMap& to) noexcept {
  const auto [v0, v1, v2] = corners(edges);
  const Vec3f a(to.point(v0)), b(to.point(v1)), c(to.point(v2));
  return to.mirrors() ? triangle_surface(a, c, b) : triangle_surface(a, b, c);
}

SphericalRectangle RectangleShape::view(const FlatEdges<float>& edges, Vec3f receiver) noexcept {
  const Vec3d x(edges.edge_x), y(edges.edge_y);
  const double width = length(x), height = length(y);
  return {Vec3d(edges.corner) - Vec3d(receiver), x / width, y / height, width, height};
}

Vec3f RectangleShape::point(const View& view, const FlatEdges<float>&, Vec3f receiver, Point2f u) noexcept {
  return Vec3f(Vec3d(receiver) + view.sample(u));
}

std::array<Vec3d, 4> RectangleShape::corners(const FlatEdges<float>& edges) noexcept {
  const Vec3d corner(edges.corner), x(edges.edge_x), y(edges.edge_y);
  return {corner, corner + x, corner + y, corner + x + y};
}

template <class Shape>
std::optional<typename Shape::View> SolidAngleSampling<Shape>::of(const FlatEdges<float>& edges,
                                                                  Vec3f receiver) noexcept {
  const auto view = Shape::view(edges, receiver);
  if (!(view.solid_angle() > kSmallestView)) return std::nullopt;
  return view;
}

template <class Shape>
DrawnPoint<float> SolidAngleSampling<Shape>::sample(bool near, const FlatEdges<float>& edges, Vec3f receiver, Point2f u,
                                                    DrawnPoint<float> otherwise) noexcept {
  if (!near) return otherwise;
  const auto view = of(edges, receiver);
  if (!view) return otherwise;
  return {Shape::point(*view, edges, receiver, u), static_cast<float>(view->solid_angle())};
}

template <class Shape>
float SolidAngleSampling<Shape>::pdf(bool near, const FlatEdges<float>& edges, Vec3f receiver,
                                     float otherwise) noexcept {
  if (!near) return otherwise;
  const auto view = of(edges, receiver);
  return view ? static_cast<float>(1 / view->solid_angle()) : otherwise;
}

template struct SolidAngleSampling<TriangleShape>;
template struct SolidAngleSampling<RectangleShape>;

// --- Loading ------------------------------------------------------------------------------------------------------

template <class Real, class Shape>
double FlatLight<Real, Shape>::power() const noexcept {
  return emitted_power(radiance_, static_cast<double>(surface_.area));
}

template <class Real, class Shape>
LightBounds FlatLight<Real, Shape>::bounds() const noexcept {
  return flat_bounds(Shape::corners(surface_.edges), surface_.normal, power());
}

template class FlatLight<float, TriangleShape>;
template class FlatLight<float, RectangleShape>;

}  // namespace equaltime
