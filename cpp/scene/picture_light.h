// PictureLight: a rectangle that shines by a texture. Points are drawn in proportion to it; near the rectangle some are
// drawn from its solid angle instead, the more the more even the texture is, so that neither a bright spot nor a near
// receiver makes much noise.
#pragma once

#include <memory>

#include "scene/area_lights.h"
#include "scene/picture.h"

namespace equaltime {

class PictureLight {
 public:
  PictureLight(const RectangleLight& rectangle, std::shared_ptr<const Picture> picture) noexcept;

  [[nodiscard]] Optional<LightSample> sample(Vec3f receiver, Point2d u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_towards(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool shows_front(Vec3f receiver) const noexcept { return rectangle_.shows_front(receiver); }
  [[nodiscard]] double power() const noexcept { return rectangle_.power(); }
  [[nodiscard]] EmitterBounds bounds() const noexcept { return rectangle_.bounds(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return picture_->memory_bytes(); }

 private:
  /// The solid angle of which points are drawn for a receiver, and the share of them.
  struct View {
    std::optional<SphericalRectangle> rectangle;
    double share;  // 0 without it
  };
  [[nodiscard]] View view(Vec3f receiver) const noexcept;
  [[nodiscard]] double density(Vec3f receiver, const View& view, Vec3f point) const noexcept;

  RectangleLight rectangle_;  // of the mean radiance
  std::shared_ptr<const Picture> picture_;
};

}  // namespace equaltime
