#include "equaltime/lights/environment.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

namespace {

constexpr double kPiD = std::numbers::pi;

}  // namespace

ImageEnvironment::ImageEnvironment(ImageEnvironmentDescription d, double radiance_scale)
    : width_(d.width), rows_(std::max(d.height, 2U) - 1), texels_(std::move(d.pixels)) {
  if (d.height == 1)
    for (std::uint32_t column = 0; column < width_; ++column) texels_.push_back(Spectrum(texels_[column]));
  // The factor that brings an image of denormal radiance to 1 is no float32.
  int exponent = 0;
  const auto mantissa = static_cast<float>(std::frexp(radiance_scale * d.scale, &exponent));
  const double scale = std::ldexp(static_cast<double>(mantissa), exponent);
  const auto scaled = [scale](float x) { return static_cast<float>(static_cast<double>(x) * scale); };
  for (Spectrum& t : texels_) t = {scaled(t.r), scaled(t.g), scaled(t.b)};
  x_axis_ = Vec3f(normalize(d.to_world.column(0)));
  y_axis_ = Vec3f(normalize(d.to_world.column(1)));
  z_axis_ = Vec3f(normalize(d.to_world.column(2)));
  for (std::uint32_t row = 0; row <= rows_; ++row)
    polar_cosine_.push_back(elementary::cos(kPiD * static_cast<double>(row) / static_cast<double>(rows_)));
  cells_ = table_above(0);
}

PiecewiseConstant2D ImageEnvironment::table_above(double floor) const {
  std::vector<double> weights(width_);
  return {rows_, [&](std::size_t i) {
            const auto row = static_cast<std::uint32_t>(i);
            for (std::uint32_t column = 0; column < width_; ++column) {
              const Spectrum corners =
                  texel(row, column) + texel(row, column + 1) + texel(row + 1, column) + texel(row + 1, column + 1);
              weights[column] = std::max(0.0, static_cast<double>(corners.mean()) * 0.25 - floor) * solid_angle(row);
            }
            return std::span<const double>(weights);
          }};
}

void ImageEnvironment::prepare(EnvironmentSampling sampling) const {
  if (sampling == EnvironmentSampling::plain) return;
  std::call_once(excess_->once, [this] {
    excess_->table = table_above(total() / (4 * kPiD));
    const bool any = excess_->table.total() > 0;  // else it is even, and sampled as it is
    excess_->made.store(any ? &excess_->table : &cells_, std::memory_order_release);
  });
}

Spectrum ImageEnvironment::interpolated(const Cell& c) const noexcept {
  const Spectrum top = texel(c.row, c.column) * (1 - c.right) + texel(c.row, c.column + 1) * c.right;
  const Spectrum bottom = texel(c.row + 1, c.column) * (1 - c.right) + texel(c.row + 1, c.column + 1) * c.right;
  return top * (1 - c.down) + bottom * c.down;
}

float ImageEnvironment::pdf(const Cell& c, const PiecewiseConstant2D& cells) const noexcept {
  const double range = polar_cosine_[c.row] - polar_cosine_[c.row + 1];
  return static_cast<float>(cells.pmf(c.row, c.column) * static_cast<double>(width_) / (2 * kPiD * range));
}

EnvironmentSample ImageEnvironment::sample(Point2d u, EnvironmentSampling sampling) const noexcept {
  const PiecewiseConstant2D& cells = table(sampling);
  const auto [row, column] = cells.choose(u.x, u.y);
  const double cosine = std::lerp(polar_cosine_[row.index], polar_cosine_[row.index + 1], row.rest);
  const double sine = std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
  const double phi = 2 * kPiD * (static_cast<double>(column.index) + column.rest + 0.5) / static_cast<double>(width_);
  const double down = elementary::acos(cosine) / kPiD * static_cast<double>(rows_) - static_cast<double>(row.index);
  const Cell cell{row.index, column.index, static_cast<float>(std::clamp(down, 0.0, 1.0)),
                  static_cast<float>(column.rest)};
  const auto [sin_phi, cos_phi] = elementary::sin_cos(phi);
  const auto x = static_cast<float>(sin_phi * sine), z = static_cast<float>(-cos_phi * sine);
  const Vec3f wi = x_axis_ * x + y_axis_ * static_cast<float>(cosine) + z_axis_ * z;
  return {wi, {interpolated(cell), pdf(cell, cells)}};
}

ImageEnvironment::Cell ImageEnvironment::cell_towards(Vec3f local) const noexcept {
  const double turn = elementary::atan2(static_cast<double>(local.x), static_cast<double>(-local.z)) / (2 * kPiD);
  const double from_first = turn * static_cast<double>(width_) - 0.5;  // in columns from the centre of the first
  const double column = from_first < 0 ? from_first + static_cast<double>(width_) : from_first;
  // The polar angle from both components keeps its accuracy at the poles.
  const double sine = elementary::hypot(static_cast<double>(local.x), static_cast<double>(local.z));
  const double row = elementary::atan2(sine, static_cast<double>(local.y)) / kPiD * static_cast<double>(rows_);
  const auto c = std::min(static_cast<std::uint32_t>(column), width_ - 1);
  const auto r = std::min(static_cast<std::uint32_t>(row), rows_ - 1);
  return {r, c, static_cast<float>(std::min(row - r, 1.0)), static_cast<float>(std::min(column - c, 1.0))};
}

LightValue<float> ImageEnvironment::eval(Vec3f wi, EnvironmentSampling sampling) const noexcept {
  const Cell cell = cell_towards({dot(wi, x_axis_), dot(wi, y_axis_), dot(wi, z_axis_)});
  return {interpolated(cell), pdf(cell, table(sampling))};
}

}  // namespace equaltime
