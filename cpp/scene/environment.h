// Environments: radiance from infinitely far away. A constant one, and one from an image in Mitsuba's mapping:
// row i lies at polar angle π·i/(height-1) from +y, column j at azimuth 2π·(j+½)/width, wrapping round; between them
// radiance is bilinear.
#pragma once

#include <optional>
#include <vector>

#include "sampling/ordered_table_2d.h"
#include "sampling/sampler.h"
#include "sampling/warps.h"
#include "scene/description.h"
#include "scene/light_types.h"

namespace equaltime {

struct EnvironmentSample {
  Vec3f wi;
  LightValue value;
};

class ConstantEnvironment {
 public:
  explicit ConstantEnvironment(const Spectrum& radiance) noexcept : radiance_(radiance) {}

  [[nodiscard]] EnvironmentSample sample(Point2d u) const noexcept {
    const Point2f uf{static_cast<float>(u.x), static_cast<float>(u.y)};
    return {square_to_uniform_sphere(uf), {radiance_, kUniformSpherePdf}};
  }
  [[nodiscard]] LightValue eval(Vec3f) const noexcept { return {radiance_, kUniformSpherePdf}; }
  /// ∫ mean radiance over all directions.
  [[nodiscard]] double total() const noexcept { return 4 * std::numbers::pi * static_cast<double>(radiance_.mean()); }
  [[nodiscard]] static std::size_t memory_bytes() noexcept { return sizeof(ConstantEnvironment); }

 private:
  Spectrum radiance_;
};

class ImageEnvironment {
 public:
  /// `radiance_scale` takes the user's radiance to the normalised one.
  ImageEnvironment(const ImageEnvironmentDescription& description, double radiance_scale);

  /// Picks a cell between four texels by its integrated radiance, then a direction uniform in the cell's solid angle:
  /// the density covers the whole support of the interpolated radiance.
  [[nodiscard]] EnvironmentSample sample(Point2d u) const noexcept;
  [[nodiscard]] LightValue eval(Vec3f wi) const noexcept;
  [[nodiscard]] double total() const noexcept { return cells_.total(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return texels_.size() * sizeof(Spectrum) + polar_cosine_.size() * sizeof(double) + cells_.memory_bytes();
  }

 private:
  struct Cell {
    std::uint32_t row, column;
    float down, right;  // place within the cell, in [0, 1)
  };
  [[nodiscard]] Spectrum texel(std::uint32_t row, std::uint32_t column) const noexcept {
    return texels_[std::size_t{row} * width_ + (column == width_ ? 0 : column)];
  }
  [[nodiscard]] Spectrum interpolated(const Cell& cell) const noexcept;
  [[nodiscard]] Cell cell_towards(Vec3f local) const noexcept;
  [[nodiscard]] float pdf(const Cell& cell) const noexcept;

  std::uint32_t width_, rows_;  // rows_: of cells, one less than of texels
  std::vector<Spectrum> texels_;
  std::vector<double> polar_cosine_;  // rows_ + 1, of the texel rows
  OrderedTable2D cells_;              // by the radiance of their corners times their solid angle
  Vec3f x_axis_, y_axis_, z_axis_;    // of the map, in world space
};

}  // namespace equaltime
