#include "scene/pixel_filter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace equaltime {

namespace {

constexpr std::size_t kIntervals = 512;
constexpr double kGaussianCut = 4;  // standard deviations, as in Mitsuba

double tent(float u, double radius) noexcept {
  const double v = 2 * static_cast<double>(u) - 1;
  const double side = 1 - std::sqrt(1 - std::abs(v));
  return std::copysign(radius * side, v);
}

}  // namespace

PixelFilter::PixelFilter(FilterKind kind, double parameter) : kind_(kind), radius_(parameter), deviation_(parameter) {
  if (kind != FilterKind::gaussian) return;
  radius_ = kGaussianCut * parameter;
  // The filter is exp(-x²/2σ²) lowered to 0 at the cut. Its running integral, by the closed form, is inverted by
  // bisection at equally likely places; between them the density is constant and the weight makes up for it.
  const double floor = std::exp(-0.5 * kGaussianCut * kGaussianCut);
  const auto running = [&](double x) {
    const double bell =
        deviation_ * std::sqrt(std::numbers::pi / 2) *
        (std::erf(x / (deviation_ * std::numbers::sqrt2)) + std::erf(kGaussianCut / std::numbers::sqrt2));
    return bell - floor * (x + radius_);
  };
  integral_ = running(radius_);
  quantiles_.resize(kIntervals + 1);
  quantiles_.front() = -radius_;
  quantiles_.back() = radius_;
  for (std::size_t i = 1; i < kIntervals; ++i) {
    double lo = -radius_, hi = radius_;
    for (int step = 0; step < 60; ++step) {
      const double mid = 0.5 * (lo + hi);
      (running(mid) * kIntervals < integral_ * static_cast<double>(i) ? lo : hi) = mid;
    }
    quantiles_[i] = 0.5 * (lo + hi);
  }
}

double PixelFilter::gaussian(double x) const noexcept {
  return std::max(0.0,
                  std::exp(-0.5 * (x / deviation_) * (x / deviation_)) - std::exp(-0.5 * kGaussianCut * kGaussianCut));
}

PixelFilter::Offset1d PixelFilter::sample_gaussian(float u) const noexcept {
  const double scaled = static_cast<double>(u) * kIntervals;
  const auto i = static_cast<std::size_t>(scaled);
  const double width = quantiles_[i + 1] - quantiles_[i];
  const double x = quantiles_[i] + (scaled - static_cast<double>(i)) * width;
  return {x, gaussian(x) * width * kIntervals / integral_};
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
