#include "equaltime/lights/textured_area_light.h"

#include <algorithm>

namespace equaltime {

namespace {

/// Of the points for near receivers, at the least: as much as that bounds how much worse they can be.
constexpr double kLeastOfView = 0.25;

}  // namespace

template <>
Point2d TexturedRectangle::place_of(Vec3f point) const noexcept {
  const Vec3d within = Vec3d(point) - Vec3d(flat_.surface_.edges.corner), x(flat_.surface_.edges.edge_x),
              y(flat_.surface_.edges.edge_y);
  return {dot(within, x) / length_squared(x), dot(within, y) / length_squared(y)};
}

template <>
Point2d TexturedTriangle::place_of(Vec3f point) const noexcept {
  const Vec3d within = Vec3d(point) - Vec3d(flat_.surface_.edges.corner), e1(flat_.surface_.edges.edge_x),
              e2(flat_.surface_.edges.edge_y);
  const Vec3d normal = cross(e1, e2);
  const double inverse = 1 / length_squared(normal);
  const double s = std::clamp(1 - dot(cross(within, e2), normal) * inverse, 0.0, 1.0);
  const double along = dot(cross(e1, within), normal) * inverse;
  return {s * s, s > 0 ? std::clamp(along / s, 0.0, 1.0) : 0.0};
}

template <class Flat>
Vec3f TexturedAreaLight<Flat>::point_at(Point2d place) const noexcept {
  const auto [a, b] = Flat::Shape::uniform(place);
  return Vec3f(Vec3d(flat_.surface_.edges.corner) + Vec3d(flat_.surface_.edges.edge_x) * a +
               Vec3d(flat_.surface_.edges.edge_y) * b);
}

template <class Flat>
typename TexturedAreaLight<Flat>::View TexturedAreaLight<Flat>::view(Vec3f receiver) const noexcept {
  View view{std::nullopt, 0};
  if (flat_.is_near(receiver)) view.flat = SolidAngleSampling<typename Flat::Shape>::of(flat_.surface_.edges, receiver);
  if (view.flat) view.share = std::clamp(1 / picture_->contrast(), kLeastOfView, 1.0);
  return view;
}

template <class Flat>
double TexturedAreaLight<Flat>::density(Vec3f receiver, const View& view, Vec3f point) const noexcept {
  const Vec3d to_light = Vec3d(point) - Vec3d(receiver);
  const double distance2 = length_squared(to_light);
  const double height = -dot(Vec3d(flat_.surface_.normal), to_light);
  if (!(height > 0)) return 0;
  const Point2d place = place_of(point);
  const double of_picture = picture_->density(place.x, place.y) * distance2 * std::sqrt(distance2) /
                            (height * static_cast<double>(flat_.surface_.area));
  return view.flat ? std::lerp(of_picture, 1 / view.flat->solid_angle(), view.share) : of_picture;
}

template <class Flat>
Optional<LightSample<float>> TexturedAreaLight<Flat>::sample(Vec3f receiver, Point2d u, float pmf) const noexcept {
  if (!faces(receiver)) return std::nullopt;
  const View seen = view(receiver);
  Vec3f point;
  if (u.x < seen.share) {
    const Point2f in_view{static_cast<float>(std::min(u.x / seen.share, 1 - 0x1p-24)), static_cast<float>(u.y)};
    point = Flat::Shape::point(*seen.flat, flat_.surface_.edges, receiver, in_view);
  } else {
    point = point_at(picture_->sample({(u.x - seen.share) / (1 - seen.share), u.y}));
  }
  const auto pdf = static_cast<float>(density(receiver, seen, point) * static_cast<double>(pmf));
  if (!(pdf > 0)) return std::nullopt;
  const Vec3f to_light = point - receiver;
  const float distance = std::sqrt(length_squared(to_light));
  return LightSample<float>{.wi = to_light * (1 / distance),
                            .radiance = flat_.radiance_,
                            .pdf = pdf,
                            .distance = distance,
                            .target = {point, flat_.surface_.normal, flat_.surface_.offset}};
}

template <class Flat>
float TexturedAreaLight<Flat>::pdf(Vec3f receiver, Vec3f, Vec3f point) const noexcept {
  return faces(receiver) ? static_cast<float>(density(receiver, view(receiver), point)) : 0.0F;
}

template <class Flat>
float TexturedAreaLight<Flat>::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const auto point = flat_.met(receiver, wi);
  return point ? pdf(receiver, wi, *point) : 0.0F;
}

template class TexturedAreaLight<RectangleLight<float>>;
template class TexturedAreaLight<TriangleLight<float>>;

}  // namespace equaltime
