#include "equaltime/sensors/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

namespace {

constexpr std::size_t kIntervals = 512;  // straight lines are within 2 % of the Gaussian at its feet, 1e-4 elsewhere
// The Gaussian is exp(-x²/2σ²) lowered to 0 at 4 standard deviations, as in Mitsuba.
constexpr double kGaussianCut = 4;
constexpr double kGaussianFloor = 3.3546262790251185e-4;  // exp(-8)
constexpr double kGaussianWithin = 0.99993665751633376;   // erf(4/√2): the part of a Gaussian that is not cut off
constexpr double kMitchellRadius = 2;

double tent(float u, double radius) noexcept {
  const double v = 2 * static_cast<double>(u) - 1;
  const double side = 1 - std::sqrt(1 - std::abs(v));
  return std::copysign(radius * side, v);
}

double gaussian(double x, double deviation, double) noexcept {
  return std::max(0.0, elementary::exp(-0.5 * (x / deviation) * (x / deviation)) - kGaussianFloor);
}

/// Mitchell & Netravali 1988, eq. 8; its integral is 1.
double mitchell(double x, double b, double c) noexcept {
  const double t = std::abs(x);
  if (t < 1) return ((12 - 9 * b - 6 * c) * t * t * t + (-18 + 12 * b + 6 * c) * t * t + (6 - 2 * b)) / 6;
  if (t < 2)
    return ((-b - 6 * c) * t * t * t + (6 * b + 30 * c) * t * t + (-12 * b - 48 * c) * t + (8 * b + 24 * c)) / 6;
  return 0;
}

double sinc(double x) noexcept {
  const double t = std::numbers::pi * x;
  return std::abs(t) < 1e-8 ? 1 : elementary::sin(t) / t;
}

/// A sinc under the middle lobe of a sinc that is as wide as the filter.
double lanczos(double x, double radius, double) noexcept {
  return std::abs(x) < radius ? sinc(x) * sinc(x / radius) : 0;
}

/// ∫ of a lanczos filter, by Simpson's rule: to 1e-12 for up to ten lobes.
double lanczos_integral(double radius) noexcept {
  constexpr int kHalves = 4096;
  const double h = radius / kHalves;
  double sum = lanczos(0, radius, 0);
  for (int i = 1; i < kHalves; ++i) sum += (i % 2 == 1 ? 4 : 2) * lanczos(i * h, radius, 0);
  return 2 * sum * h / 3;
}

/// In pixels: what is seen from there still has places that single precision holds.
constexpr double kWidest = 1e4;

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, double parameter, double second)
    : kind_(kind), radius_(parameter), parameter_(parameter), second_(second) {
  if (kind == FilterKind::mitchell ? !std::isfinite(parameter + second) : !(parameter > 0 && std::isfinite(parameter)))
    throw std::invalid_argument("a pixel filter needs finite parameters, and a positive size");
  if (kind != FilterKind::mitchell && parameter > kWidest)
    throw std::invalid_argument("a pixel filter reaches no further than ten thousand pixels");
  switch (kind) {
    case FilterKind::gaussian: {
      radius_ = kGaussianCut * parameter;
      const double bell = std::sqrt(2 * std::numbers::pi) * kGaussianWithin;
      tabulate(gaussian, parameter * (bell - 2 * kGaussianCut * kGaussianFloor));
      break;
    }
    case FilterKind::mitchell:
      radius_ = kMitchellRadius;
      tabulate(mitchell, 1);
      break;
    case FilterKind::lanczos:
      tabulate(lanczos, lanczos_integral(parameter));
      break;
    case FilterKind::box:
    case FilterKind::tent:
      break;
  }
}

/// Between evenly spaced places the density is a straight line through the filter's absolute values; the weight makes
/// up for what that leaves, and for the trapezoids' sum, which is not the integral.
void PixelFilter::tabulate(Profile profile, double integral) {
  profile_ = profile;
  heights_.resize(kIntervals + 1);
  for (std::size_t i = 0; i <= kIntervals; ++i)
    heights_[i] = std::abs(profile(place(static_cast<double>(i)), parameter_, second_));
  std::vector<double> trapezoids(kIntervals);
  for (std::size_t i = 0; i < kIntervals; ++i)
    trapezoids[i] = 0.5 * (heights_[i] + heights_[i + 1]) * (place(1) - place(0));
  intervals_ = PiecewiseConstant1D(trapezoids);
  scale_ = intervals_.total() / integral;
}

double PixelFilter::place(double interval) const noexcept {
  return radius_ * (2 * interval / static_cast<double>(kIntervals) - 1);
}

PixelFilter::Offset1d PixelFilter::sample_table(float u) const noexcept {
  // Half a step up: never the very ends, where filter and density are both 0.
  const auto [i, rest] = intervals_.choose(static_cast<double>(u) + 0x1p-25);
  const double a = heights_[i], b = heights_[i + 1];
  const double height = std::sqrt(std::lerp(a * a, b * b, rest));  // of the line, where its area is divided so
  const double x = place(static_cast<double>(i) + rest * (a + b) / (a + height));
  return {x, scale_ * profile_(x, parameter_, second_) / height};
}

PixelFilter::Offset PixelFilter::sample(Point2f u) const noexcept {
  switch (kind_) {
    case FilterKind::tent:
      return {tent(u.x, radius_), tent(u.y, radius_), 1};
    case FilterKind::gaussian:
    case FilterKind::mitchell:
    case FilterKind::lanczos: {
      const Offset1d x = sample_table(u.x), y = sample_table(u.y);
      return {x.x, y.x, static_cast<float>(x.weight * y.weight)};
    }
    case FilterKind::box:
      break;
  }
  return {radius_ * (2 * static_cast<double>(u.x) - 1), radius_ * (2 * static_cast<double>(u.y) - 1), 1};
}

PixelFilter::Drawn PixelFilter::drawn(double x, double y) const noexcept {
  const Drawn across = drawn_1d(x), along = drawn_1d(y);
  return {across.density * along.density, across.weight * along.weight};
}

PixelFilter::Drawn PixelFilter::drawn_1d(double x) const noexcept {
  if (!(std::abs(x) < radius_)) return {0, 0};
  if (kind_ == FilterKind::box) return {0.5 / radius_, 1};
  if (kind_ == FilterKind::tent) return {(1 - std::abs(x) / radius_) / radius_, 1};
  const double interval = 0.5 * (x / radius_ + 1) * static_cast<double>(kIntervals);
  const auto i = std::min(static_cast<std::size_t>(interval), kIntervals - 1);
  const double height = std::lerp(heights_[i], heights_[i + 1], interval - static_cast<double>(i));
  if (!(height > 0)) return {0, 0};
  return {height / intervals_.total(), scale_ * profile_(x, parameter_, second_) / height};
}

}  // namespace equaltime
