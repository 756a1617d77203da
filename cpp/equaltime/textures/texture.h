// Textures: a colour for every (u, v), or what a mesh says of itself at a point. Bitmaps keep the precision of their
// file in memory and are decoded as they are looked up: bilinear between texel centres, or the nearest texel.
#pragma once

#include <array>
#include <optional>
#include <variant>
#include <vector>

#include "equaltime/base/index.h"
#include "equaltime/base/type_list.h"
#include "equaltime/math/point.h"
#include "equaltime/math/spectrum.h"
#include "equaltime/textures/texture_description.h"

namespace equaltime {

/// Where on a surface a texture is looked up.
struct TextureCoords {
  Point2f uv;
  std::uint32_t shape = kNone, primitive = 0;
  std::array<std::uint32_t, 3> corners{};  // on a mesh: the vertices of the triangle, and where in it the point is
  Point2f barycentric{};
};

/// The place of a point of a triangle, whose vertices have texture coordinates or none (null).
[[nodiscard]] inline TextureCoords on_triangle(Point2f barycentric, std::uint32_t shape, std::uint32_t primitive,
                                               const std::array<std::uint32_t, 3>& corners,
                                               const Point2f* uvs) noexcept {
  if (uvs == nullptr) return {barycentric, shape, primitive, corners, barycentric};
  const auto& [a, b, c] = corners;
  const auto [u, v] = barycentric;
  const float w = 1 - u - v;
  return {{uvs[a].x * w + uvs[b].x * u + uvs[c].x * v, uvs[a].y * w + uvs[b].y * u + uvs[c].y * v},
          shape,
          primitive,
          corners,
          barycentric};
}

/// The lines of u and of v along which a texture changes its rule, from 0 to 1: between them it is linear in both, or
/// the same if it goes by steps. Empty if there are no such lines, or too many.
struct TextureGrid {
  std::vector<double> u, v;
  bool steps = false;
};

/// Where a texture changes its rule: where its own coordinates, times so many columns and rows, are whole numbers and a
/// part.
struct TextureLattice {
  std::array<double, 6> from_uv;  // to columns and rows less the part: rows of an affine map
  bool steps;
};

/// The affine map from a surface's uv to a texture's, in float32.
class UvMap {
 public:
  explicit UvMap(const UvTransform& t) noexcept;
  [[nodiscard]] Point2f operator()(Point2f uv) const noexcept {
    return {m_[0] * uv.x + m_[1] * uv.y + m_[2], m_[3] * uv.x + m_[4] * uv.y + m_[5]};
  }
  /// What a change along the texture's own coordinates is along the surface's.
  [[nodiscard]] Point2f pull_back(Point2f gradient) const noexcept {
    return {m_[0] * gradient.x + m_[3] * gradient.y, m_[1] * gradient.x + m_[4] * gradient.y};
  }
  /// Where the texture's own coordinates, times so many, are whole numbers and a part; nothing if they are not parallel
  /// to the surface's.
  [[nodiscard]] TextureGrid grid(double columns, double rows, double part, std::size_t most) const;
  [[nodiscard]] std::array<double, 6> times(double columns, double rows, double part) const noexcept;

 private:
  std::array<float, 6> m_;
};

class Bitmap {
 public:
  static constexpr const char* name = "bitmap";

  /// Throws std::invalid_argument if the texels are not as many as the size says, or one of them is not finite.
  explicit Bitmap(BitmapDescription description);

  [[nodiscard]] Spectrum eval(const TextureCoords& at) const noexcept;
  /// How the luminance changes with u and v; not at all between the steps of nearest texels.
  [[nodiscard]] Point2f gradient(const TextureCoords& at) const noexcept;
  /// One number for a colour: its luminance.
  [[nodiscard]] float number(const TextureCoords& at) const noexcept { return eval(at).luminance(); }
  /// The colour, if it is the same everywhere.
  [[nodiscard]] std::optional<Spectrum> constant() const noexcept;
  [[nodiscard]] TextureGrid grid(std::size_t most) const;
  [[nodiscard]] std::optional<TextureLattice> lattice() const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return sizeof(*this) + texels_.size(); }

 private:
  template <class Decode>
  [[nodiscard]] Spectrum look_up(Point2f place, Decode decode) const noexcept;
  [[nodiscard]] Spectrum texel(std::size_t index) const noexcept;
  [[nodiscard]] std::size_t count() const noexcept { return std::size_t{width_} * height_; }

  UvMap to_uv_;
  std::uint32_t width_, height_, channels_;
  TexelFormat format_;
  TextureFilter filter_;
  TextureWrap wrap_;
  std::vector<std::byte> texels_;
  std::array<float, 256> decoded_{};  // of the values of a byte
};

class Checkerboard {
 public:
  static constexpr const char* name = "checkerboard";

  explicit Checkerboard(const CheckerboardDescription& d) noexcept;
  /// Of one colour, for which one number stands.
  Checkerboard(const Spectrum& color, float number) noexcept
      : to_uv_(kSameUv), colors_{color, color}, numbers_{number, number} {}

  [[nodiscard]] Spectrum eval(const TextureCoords& at) const noexcept { return colors_[square_at(at.uv)]; }
  /// One number for a colour: its mean, as Mitsuba has it here. As there, it is that of the other colour: where a
  /// checkerboard gives a weight, an opacity or a roughness, its squares have changed places.
  [[nodiscard]] float number(const TextureCoords& at) const noexcept { return numbers_[square_at(at.uv)]; }
  [[nodiscard]] static Point2f gradient(const TextureCoords&) noexcept { return {0, 0}; }
  [[nodiscard]] std::optional<Spectrum> constant() const noexcept;
  [[nodiscard]] TextureGrid grid(std::size_t most) const;
  [[nodiscard]] std::optional<TextureLattice> lattice() const noexcept;
  [[nodiscard]] static std::size_t memory_bytes() noexcept { return sizeof(Checkerboard); }

 private:
  /// Which of the two colours is there.
  [[nodiscard]] std::size_t square_at(Point2f uv) const noexcept;

  UvMap to_uv_;
  Spectrum colors_[2];
  float numbers_[2];
};

/// What meshes say of themselves: each shape has its own numbers, of its vertices or its faces, or is black.
class MeshAttribute {
 public:
  static constexpr const char* name = "mesh_attribute";

  /// Throws std::invalid_argument unless there is one value, finite, for each of so many vertices or faces.
  void add(std::uint32_t shape, AttributeValues values, std::size_t vertices, std::size_t faces);
  [[nodiscard]] Spectrum eval(const TextureCoords& place) const noexcept;
  /// One number for a colour: its luminance.
  [[nodiscard]] float number(const TextureCoords& place) const noexcept { return eval(place).luminance(); }
  [[nodiscard]] static Point2f gradient(const TextureCoords&) noexcept { return {0, 0}; }
  [[nodiscard]] static std::optional<Spectrum> constant() noexcept { return std::nullopt; }
  [[nodiscard]] static TextureGrid grid(std::size_t) { return {}; }
  [[nodiscard]] static std::optional<TextureLattice> lattice() noexcept { return std::nullopt; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  std::vector<std::uint32_t> of_shape_;  // which of the values, by shape
  std::vector<AttributeValues> values_;
};

using Textures = TypeList<MeshAttribute, Bitmap, Checkerboard>;
using Texture = Textures::Variant;

[[nodiscard]] Texture make_texture(TextureDescription description);

[[nodiscard]] inline Spectrum eval(const Texture& texture, const TextureCoords& at) noexcept {
  return visit<kAllEffects>(texture, [&](const auto& t) noexcept { return t.eval(at); });
}

[[nodiscard]] inline float number(const Texture& texture, const TextureCoords& at) noexcept {
  return visit<kAllEffects>(texture, [&](const auto& t) noexcept { return t.number(at); });
}
[[nodiscard]] inline Point2f gradient(const Texture& texture, const TextureCoords& at) noexcept {
  return visit<kAllEffects>(texture, [&](const auto& t) noexcept { return t.gradient(at); });
}

}  // namespace equaltime
