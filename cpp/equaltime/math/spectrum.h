// Rgb: linear RGB radiance, throughput or reflectance; Spectrum: that of one path.
#pragma once

#include <cmath>

#include "equaltime/math/vector.h"

namespace equaltime {

template <class Real>
struct Rgb {
  Real r = 0, g = 0, b = 0;

  constexpr Rgb() noexcept = default;
  constexpr explicit Rgb(Real v) noexcept : r(v), g(v), b(v) {}
  constexpr Rgb(Real r_, Real g_, Real b_) noexcept : r(r_), g(g_), b(b_) {}
  template <class Other>
  constexpr explicit Rgb(const Rgb<Other>& s) noexcept : r(s.r), g(s.g), b(s.b) {}

  constexpr Rgb& operator+=(const Rgb& s) noexcept { return *this = *this + s; }
  constexpr Rgb& operator*=(const Rgb& s) noexcept { return *this = *this * s; }
  constexpr Rgb& operator*=(Real s) noexcept { return *this = *this * s; }
  constexpr bool operator==(const Rgb&) const noexcept = default;

  friend constexpr Rgb operator+(const Rgb& a, const Rgb& b) noexcept { return {a.r + b.r, a.g + b.g, a.b + b.b}; }
  friend constexpr Rgb operator*(const Rgb& a, const Rgb& b) noexcept { return {a.r * b.r, a.g * b.g, a.b * b.b}; }
  friend constexpr Rgb operator*(const Rgb& a, Real s) noexcept { return {a.r * s, a.g * s, a.b * s}; }
  friend constexpr Rgb operator*(Real s, const Rgb& a) noexcept { return a * s; }

  [[nodiscard]] constexpr Mask<Real> is_black() const noexcept { return r == 0 && g == 0 && b == 0; }
  [[nodiscard]] constexpr Real sum() const noexcept { return r + g + b; }
  [[nodiscard]] constexpr Real max_component() const noexcept { return max(r, max(g, b)); }
  /// Rec. 709, with Mitsuba's digits.
  [[nodiscard]] constexpr Real luminance() const noexcept { return 0.212671F * r + 0.71516F * g + 0.072169F * b; }
  [[nodiscard]] constexpr Real mean() const noexcept { return (r + g + b) * (1.0F / 3.0F); }
  [[nodiscard]] bool is_finite() const noexcept { return std::isfinite(r) && std::isfinite(g) && std::isfinite(b); }
};

using Spectrum = Rgb<float>;

template <class Real>
constexpr Rgb<Real> select(Mask<Real> first, const Rgb<Real>& a, const Rgb<Real>& b) noexcept {
  if constexpr (LaneTraits<Real>::width == 1)
    return first ? a : b;  // a choice of an address
  else
    return {select(first, a.r, b.r), select(first, a.g, b.g), select(first, a.b, b.b)};
}

[[nodiscard]] constexpr Spectrum spectrum(const Vec3d& v) noexcept {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace equaltime
