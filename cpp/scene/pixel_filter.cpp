#include "scene/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace equaltime {

namespace {

constexpr std::size_t kIntervals = 512;  // straight lines are within 2 % of the Gaussian at its feet, 1e-4 elsewhere
// The Gaussian is exp(-x²/2σ²) lowered to 0 at 4 standard deviations, as in Mitsuba.
constexpr double kGaussianCut = 4;
constexpr double kGaussianFloor = 3.3546262790251185e-4;  // exp(-8)

double tent(float u, double radius) noexcept {
  const double v = 2 * static_cast<double>(u) - 1;
  const double side = 1 - std::sqrt(1 - std::abs(v));
  return std::copysign(radius * side, v);
}

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, double parameter) : kind_(kind), radius_(parameter), deviation_(parameter) {
  if (kind != FilterKind::gaussian) return;
  radius_ = kGaussianCut * parameter;
  // Between evenly spaced places the density is a straight line through the filter's values; the weight makes up for
  // what that leaves, and for the trapezoids' sum, which is not the integral.
  heights_.resize(kIntervals + 1);
  for (std::size_t i = 0; i <= kIntervals; ++i) heights_[i] = gaussian(place(static_cast<double>(i)));
  std::vector<double> trapezoids(kIntervals);
  for (std::size_t i = 0; i < kIntervals; ++i)
    trapezoids[i] = 0.5 * (heights_[i] + heights_[i + 1]) * (place(1) - place(0));
  intervals_ = OrderedTable(trapezoids);
  const double bell = std::sqrt(2 * std::numbers::pi) * std::erf(kGaussianCut / std::numbers::sqrt2);
  scale_ = intervals_.total() / (deviation_ * (bell - 2 * kGaussianCut * kGaussianFloor));
}

double PixelFilter::place(double interval) const noexcept {
  return radius_ * (2 * interval / static_cast<double>(kIntervals) - 1);
}

double PixelFilter::gaussian(double x) const noexcept {
  return std::max(0.0, std::exp(-0.5 * (x / deviation_) * (x / deviation_)) - kGaussianFloor);
}

PixelFilter::Offset1d PixelFilter::sample_gaussian(float u) const noexcept {
  // Half a step up: never the very ends, where filter and density are both 0.
  const auto [i, rest] = intervals_.choose(static_cast<double>(u) + 0x1p-25);
  const double a = heights_[i], b = heights_[i + 1];
  const double height = std::sqrt(std::lerp(a * a, b * b, rest));  // of the line, where its area is divided so
  const double x = place(static_cast<double>(i) + rest * (a + b) / (a + height));
  return {x, scale_ * gaussian(x) / height};
}

PixelFilter::Offset PixelFilter::sample(Point2f u) const noexcept {
  switch (kind_) {
    case FilterKind::tent:
      return {tent(u.x, radius_), tent(u.y, radius_), 1};
    case FilterKind::gaussian: {
      const Offset1d x = sample_gaussian(u.x), y = sample_gaussian(u.y);
      return {x.x, y.x, static_cast<float>(x.weight * y.weight)};
    }
    case FilterKind::box:
      break;
  }
  return {radius_ * (2 * static_cast<double>(u.x) - 1), radius_ * (2 * static_cast<double>(u.y) - 1), 1};
}

}  // namespace equaltime
