// Environments: radiance from infinitely far away. A constant one, and one from an image in Mitsuba's mapping:
// row i lies at polar angle π·i/(height-1) from +y, column j at azimuth 2π·(j+½)/width, wrapping round; between them
// radiance is bilinear.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "equaltime/lights/light_types.h"
#include "equaltime/math/transform.h"
#include "equaltime/sampling/piecewise_constant_2d.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

/// How directions of an image are drawn: by radiance; or by what exceeds its mean, and never where nothing does, which
/// is better beside BSDF sampling, since that serves the rest (MIS compensation: Karlík et al. 2019, eq. 14).
enum class EnvironmentSampling : std::uint8_t { plain, compensated };

struct EnvironmentSample {
  Vec3f wi;
  LightValue<float> value;
};

class ConstantEnvironment {
 public:
  static constexpr const char* name = "constant";

  explicit ConstantEnvironment(const Spectrum& radiance) noexcept : radiance_(radiance) {}

  void prepare(EnvironmentSampling) const noexcept {}
  /// Nothing of it exceeds its mean: however it is to be sampled, directions are uniform.
  [[nodiscard]] EnvironmentSample sample(Point2d u, EnvironmentSampling) const noexcept {
    const Point2f uf{static_cast<float>(u.x), static_cast<float>(u.y)};
    return {square_to_uniform_sphere(uf), {radiance_, kUniformSpherePdf}};
  }
  [[nodiscard]] LightValue<float> eval(Vec3f, EnvironmentSampling) const noexcept {
    return {radiance_, kUniformSpherePdf};
  }
  /// ∫ mean radiance over all directions.
  [[nodiscard]] double total() const noexcept { return 4 * std::numbers::pi * static_cast<double>(radiance_.mean()); }
  [[nodiscard]] static std::size_t memory_bytes() noexcept { return sizeof(ConstantEnvironment); }

 private:
  Spectrum radiance_;
};

struct ImageEnvironmentDescription {
  std::uint32_t width = 0, height = 0;
  std::vector<Spectrum> pixels;  // rows from the +y pole
  double scale = 1;
  Transform to_world;
};

class ImageEnvironment {
 public:
  static constexpr const char* name = "image";

  /// `radiance_scale` takes the user's radiance to the normalised one.
  ImageEnvironment(ImageEnvironmentDescription description, double radiance_scale);

  /// To be called before a sampling is used: makes its table, once, whoever asks first. Any number of threads may.
  void prepare(EnvironmentSampling sampling) const;
  /// Picks a cell between four texels by its integrated radiance, then a direction uniform in the cell's solid angle:
  /// if `plain`, the density covers the whole support of the interpolated radiance.
  [[nodiscard]] EnvironmentSample sample(Point2d u, EnvironmentSampling sampling) const noexcept;
  [[nodiscard]] LightValue<float> eval(Vec3f wi, EnvironmentSampling sampling) const noexcept;
  [[nodiscard]] double total() const noexcept { return cells_.total(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    const PiecewiseConstant2D* excess = excess_->made.load(std::memory_order_acquire);
    return texels_.size() * sizeof(Spectrum) + polar_cosine_.size() * sizeof(double) + cells_.memory_bytes() +
           (excess ? excess->memory_bytes() : 0);
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
  [[nodiscard]] float pdf(const Cell& cell, const PiecewiseConstant2D& cells) const noexcept;
  [[nodiscard]] double solid_angle(std::uint32_t row) const noexcept {
    return (polar_cosine_[row] - polar_cosine_[row + 1]) * 2 * std::numbers::pi / static_cast<double>(width_);
  }
  /// A table of cells. The weight of a cell is the integral over it of max(0, radiance - floor).
  [[nodiscard]] PiecewiseConstant2D table_above(double floor) const;
  [[nodiscard]] const PiecewiseConstant2D& table(EnvironmentSampling sampling) const noexcept {
    return sampling == EnvironmentSampling::plain ? cells_ : *excess_->made.load(std::memory_order_acquire);
  }

  /// By what exceeds the mean, for those strategies that ask for it.
  struct LazyTable {
    std::once_flag once;
    PiecewiseConstant2D table;
    std::atomic<const PiecewiseConstant2D*> made{nullptr};
  };

  std::uint32_t width_, rows_;  // rows_: of cells, one less than of texels
  std::vector<Spectrum> texels_;
  std::vector<double> polar_cosine_;  // rows_ + 1, of the texel rows
  PiecewiseConstant2D cells_;         // by the radiance of their corners times their solid angle
  std::unique_ptr<LazyTable> excess_ = std::make_unique<LazyTable>();
  Vec3f x_axis_, y_axis_, z_axis_;  // of the map, in world space
};

}  // namespace equaltime
