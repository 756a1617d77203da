#include "scene/picture_light.h"

#include <algorithm>

namespace equaltime {

namespace {

/// Of the points for near receivers, at the least: as much as that bounds how much worse they can be.
constexpr double kLeastOfView = 0.25;

}  // namespace

PictureLight::PictureLight(const RectangleLight& rectangle, std::shared_ptr<const Picture> picture) noexcept
    : rectangle_(rectangle), picture_(std::move(picture)) {}

PictureLight::View PictureLight::view(Vec3f receiver) const noexcept {
  View view{std::nullopt, 0};
  if (rectangle_.is_near(receiver)) view.rectangle = rectangle_.near_view(receiver);
  if (view.rectangle) view.share = std::clamp(1 / picture_->contrast(), kLeastOfView, 1.0);
  return view;
}

double PictureLight::density(Vec3f receiver, const View& view, Vec3f point) const noexcept {
  const Vec3d to_light = Vec3d(point) - Vec3d(receiver), within = Vec3d(point) - Vec3d(rectangle_.corner_);
  const Vec3d x(rectangle_.edge_x_), y(rectangle_.edge_y_);
  const double distance2 = length_squared(to_light);
  const double height = -dot(Vec3d(rectangle_.normal_), to_light);
  if (!(height > 0)) return 0;
  const double of_picture = picture_->density(dot(within, x) / length_squared(x), dot(within, y) / length_squared(y)) *
                            distance2 * std::sqrt(distance2) / (height * static_cast<double>(rectangle_.area_));
  return view.rectangle ? std::lerp(of_picture, 1 / view.rectangle->solid_angle(), view.share) : of_picture;
}

Optional<LightSample> PictureLight::sample(Vec3f receiver, Point2d u, float pmf) const noexcept {
  if (!shows_front(receiver)) return std::nullopt;
  const View seen = view(receiver);
  Vec3f point;
  if (u.x < seen.share) {
    const Point2f in_view{static_cast<float>(std::min(u.x / seen.share, 1 - 0x1p-24)), static_cast<float>(u.y)};
    point = Vec3f(Vec3d(receiver) + seen.rectangle->sample(in_view));
  } else {
    const Point2d place = picture_->sample({(u.x - seen.share) / (1 - seen.share), u.y});
    point =
        Vec3f(Vec3d(rectangle_.corner_) + Vec3d(rectangle_.edge_x_) * place.x + Vec3d(rectangle_.edge_y_) * place.y);
  }
  const auto pdf = static_cast<float>(density(receiver, seen, point) * static_cast<double>(pmf));
  if (!(pdf > 0)) return std::nullopt;
  const Vec3f to_light = point - receiver;
  const float distance = std::sqrt(length_squared(to_light));
  return LightSample{
      to_light * (1 / distance), rectangle_.radiance_, pdf, distance, {point, rectangle_.normal_, rectangle_.offset_}};
}

float PictureLight::pdf(Vec3f receiver, Vec3f, Vec3f point) const noexcept {
  return shows_front(receiver) ? static_cast<float>(density(receiver, view(receiver), point)) : 0.0F;
}

float PictureLight::pdf_towards(Vec3f receiver, Vec3f wi) const noexcept {
  const auto point = rectangle_.met(receiver, wi);
  return point ? pdf(receiver, wi, *point) : 0.0F;
}

}  // namespace equaltime
