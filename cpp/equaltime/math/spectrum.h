// Spectrum: linear RGB radiance, throughput or reflectance, float32.
#pragma once

#include <algorithm>
#include <cmath>

#include "equaltime/math/vector.h"

namespace equaltime {

struct Spectrum {
  float r = 0, g = 0, b = 0;

  constexpr Spectrum() noexcept = default;
  constexpr explicit Spectrum(float v) noexcept : r(v), g(v), b(v) {}
  constexpr Spectrum(float r_, float g_, float b_) noexcept : r(r_), g(g_), b(b_) {}

  constexpr Spectrum& operator+=(const Spectrum& s) noexcept { return *this = *this + s; }
  constexpr Spectrum& operator*=(const Spectrum& s) noexcept { return *this = *this * s; }
  constexpr Spectrum& operator*=(float s) noexcept { return *this = *this * s; }
  constexpr bool operator==(const Spectrum&) const noexcept = default;

  friend constexpr Spectrum operator+(const Spectrum& a, const Spectrum& b) noexcept {
    return {a.r + b.r, a.g + b.g, a.b + b.b};
  }
  friend constexpr Spectrum operator*(const Spectrum& a, const Spectrum& b) noexcept {
    return {a.r * b.r, a.g * b.g, a.b * b.b};
  }
  friend constexpr Spectrum operator*(const Spectrum& a, float s) noexcept { return {a.r * s, a.g * s, a.b * s}; }
  friend constexpr Spectrum operator*(float s, const Spectrum& a) noexcept { return a * s; }

  [[nodiscard]] constexpr bool is_black() const noexcept { return r == 0 && g == 0 && b == 0; }
  [[nodiscard]] constexpr float sum() const noexcept { return r + g + b; }
  [[nodiscard]] constexpr float max_component() const noexcept { return std::max(r, std::max(g, b)); }
  /// Rec. 709, with Mitsuba's digits.
  [[nodiscard]] constexpr float luminance() const noexcept { return 0.212671F * r + 0.71516F * g + 0.072169F * b; }
  [[nodiscard]] constexpr float mean() const noexcept { return (r + g + b) * (1.0F / 3.0F); }
  [[nodiscard]] bool is_finite() const noexcept { return std::isfinite(r) && std::isfinite(g) && std::isfinite(b); }
};

[[nodiscard]] constexpr Spectrum spectrum(const Vec3d& v) noexcept {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

}  // namespace equaltime
