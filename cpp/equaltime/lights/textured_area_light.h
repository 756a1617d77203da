// TexturedAreaLight: a rectangle or a triangle that shines by a texture. Points are drawn in proportion to it; near the
// light some are drawn from its solid angle instead, the more the more even the texture is, so that neither a bright
// spot nor a near receiver makes much noise.
#pragma once

#include <memory>

#include "equaltime/base/effects.h"
#include "equaltime/lights/flat_light.h"
#include "equaltime/sampling/image_distribution.h"

namespace equaltime {

/// A light that an instance may put elsewhere.
template <class Flat>
concept Movable = requires(const Flat& flat, const AffineMap& to) {
  flat.placed(to);
};

template <class Flat>
class TexturedAreaLight {
 public:
  static constexpr const char* name = "textured";
  static constexpr bool Effects::*needs = &Effects::textures;

  /// `flat` has the mean radiance. The picture lies on a rectangle along its edges; on a triangle, see `point_at`.
  TexturedAreaLight(const Flat& flat, std::shared_ptr<const ImageDistribution> picture) noexcept
      : flat_(flat), picture_(std::move(picture)) {}

  [[nodiscard]] Optional<LightSample<float>> sample(Vec3f receiver, Point2d u, float pmf) const noexcept;
  [[nodiscard]] float pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept;
  [[nodiscard]] float pdf_direction(Vec3f receiver, Vec3f wi) const noexcept;
  [[nodiscard]] bool faces(Vec3f receiver) const noexcept { return flat_.faces(receiver); }
  [[nodiscard]] double power() const noexcept { return flat_.power(); }
  [[nodiscard]] LightBounds bounds() const noexcept { return flat_.bounds(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return picture_->memory_bytes(); }
  /// Returns the light where an instance puts it; the instance mirrors nothing.
  template <Movable F = Flat>  // a template, so that it need not compile for lights that cannot be moved
  [[nodiscard]] TexturedAreaLight placed(const AffineMap& to) const noexcept {
    return {flat_.placed(to), picture_};
  }
  /// As if it shone evenly.
  [[nodiscard]] const Flat& even() const noexcept { return flat_; }

 private:
  /// The solid angle of which points are drawn for a receiver, and the share of them.
  struct View {
    std::optional<typename Flat::Shape::View> flat;
    double share;  // 0 without it
  };
  [[nodiscard]] View view(Vec3f receiver) const noexcept;
  [[nodiscard]] double density(Vec3f receiver, const View& view, Vec3f point) const noexcept;
  /// The point of a place in the unit square, whose equal areas are equal areas of the light; and back. On a triangle
  /// the first coordinate is the area that a parallel to the edge from the first vertex to the third cuts off beyond.
  [[nodiscard]] Vec3f point_at(Point2d place) const noexcept;
  [[nodiscard]] Point2d place_of(Vec3f point) const noexcept;

  Flat flat_;
  std::shared_ptr<const ImageDistribution> picture_;
};

using TexturedRectangle = TexturedAreaLight<RectangleLight<float>>;
using TexturedTriangle = TexturedAreaLight<TriangleLight<float>>;

}  // namespace equaltime
