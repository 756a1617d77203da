// Elementary functions in float64, by series: no libm, whose results differ between its versions and, as it chooses
// code by processor, between machines. They branch little, so that lanes can do them later. Errors are in units of the
// last place (ulp) of the result; tests/math/test_elementary.cpp holds them to that.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "equaltime/math/numeric.h"

namespace equaltime::elementary {

namespace detail {

/// Evaluates a polynomial. The first coefficient is the constant one.
template <std::size_t N>
[[nodiscard]] constexpr double polynomial(double x, const std::array<double, N>& coefficients) noexcept {
  double sum = coefficients[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

/// 1/n! for each n from `first` on; for every second n if signs alternate, of which the first is `sign`.
template <std::size_t N>
[[nodiscard]] constexpr std::array<double, N> inverse_factorials(int first, bool alternate, double sign = 1) noexcept {
  std::array<double, N> c{};
  double value = sign;
  for (int n = 2; n <= first; ++n) value /= n;
  for (std::size_t i = 0; i < N; ++i) {
    c[i] = value;
    value /= ++first;
    if (alternate) value /= -(++first);
  }
  return c;
}

/// 1/3, 1/5, …: coefficients of the series of atanh after its first term; with alternating signs, of atan.
template <std::size_t N>
[[nodiscard]] constexpr std::array<double, N> inverse_odd(bool alternate) noexcept {
  std::array<double, N> c{};
  for (std::size_t i = 0; i < N; ++i) c[i] = (alternate && i % 2 == 0 ? -1.0 : 1.0) / static_cast<double>(2 * i + 3);
  return c;
}

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInf = std::numeric_limits<double>::infinity();

[[nodiscard]] constexpr std::int64_t nearest(double x) noexcept {
  return static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5);
}
[[nodiscard]] constexpr double power_of_two(std::int64_t k) noexcept {
  return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52U);
}
constexpr double kLn2High = 0x1.62e42feep-1,
                 kLn2Low = 0x1.a39ef35793c76p-33;  // the first has 32 bits: its multiples are exact

/// 2·atanh(s) for |s| <= 0.172, that is the logarithm of (1 + s) / (1 - s).
[[nodiscard]] constexpr double twice_atanh(double s) noexcept {
  constexpr auto kSeries = inverse_odd<10>(false);
  const double s2 = s * s;
  return 2 * s + 2 * s * s2 * polynomial(s2, kSeries);
}

/// For |x| <= π/4.
[[nodiscard]] constexpr double short_sin(double x) noexcept {
  constexpr auto kSeries = inverse_factorials<8>(3, true, -1);
  const double x2 = x * x;
  return x + x * x2 * polynomial(x2, kSeries);
}
[[nodiscard]] constexpr double short_cos(double x) noexcept {
  constexpr auto kSeries = inverse_factorials<8>(4, true);
  const double x2 = x * x, half = 0.5 * x2, rest = 1 - half;
  return rest + (((1 - rest) - half) + x2 * x2 * polynomial(x2, kSeries));
}

/// An angle as quarter turns, and the rest, at most π/4. The first part of π/2 has 33 bits, so that quarters of up to
/// 20 bits are exact.
struct Quarters {
  std::int64_t count;
  double rest;
};
inline constexpr double kLargestAngle = 0x1p20;
[[nodiscard]] constexpr Quarters quarters(double x) noexcept {
  constexpr double kHigh = 0x1.921fb544p0, kLow = 0x1.0b4611a626331p-34;
  const std::int64_t n = nearest(x * (2 * std::numbers::inv_pi));
  const auto count = static_cast<double>(n);
  return {n, (x - count * kHigh) - count * kLow};
}

/// Returns x, negated in the second half of a turn.
[[nodiscard]] constexpr double negated_if(std::int64_t quarter, double x) noexcept {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(x) ^ (static_cast<std::uint64_t>(quarter & 2) << 62U));
}

}  // namespace detail

/// Sine and cosine of one angle.
template <class Real>
struct SinCos {
  Real sin, cos;
};

/// Sine and cosine of an angle in radians, |x| <= 2^20; NaN beyond. Error: 2^-52, and of the sine 1 ulp for
/// |x| <= π/4.
[[nodiscard]] constexpr SinCos<double> sin_cos(double x) noexcept {
  if (!(std::abs(x) <= detail::kLargestAngle)) return {detail::kNaN, detail::kNaN};
  const auto [count, rest] = detail::quarters(x);
  const double s = detail::short_sin(rest), c = detail::short_cos(rest);
  const bool odd = (count & 1) != 0;
  return {detail::negated_if(count, select(odd, c, s)), detail::negated_if(count + 1, select(odd, s, c))};
}
[[nodiscard]] constexpr double sin(double x) noexcept { return sin_cos(x).sin; }
[[nodiscard]] constexpr double cos(double x) noexcept { return sin_cos(x).cos; }
/// sin/cos: relative error 2^-51 where neither is near 0.
[[nodiscard]] constexpr double tan(double x) noexcept {
  const auto [s, c] = sin_cos(x);
  return s / c;
}

/// Error: 1 ulp; infinite above 709.78, and 0 below -745.13.
[[nodiscard]] constexpr double exp(double x) noexcept {
  if (!(x < 709.782712893384)) return x != x ? x : detail::kInf;
  if (x < -745.1332191019412) return 0;
  const std::int64_t k = detail::nearest(x * std::numbers::log2e);
  const auto count = static_cast<double>(k);
  const double high = x - count * detail::kLn2High, low = count * detail::kLn2Low, r = high - low;
  constexpr auto kSeries = detail::inverse_factorials<12>(2, false);
  const double value = 1 + (r + r * r * detail::polynomial(r, kSeries));
  const std::int64_t half = k / 2;
  return value * detail::power_of_two(half) * detail::power_of_two(k - half);
}

/// Error: 2 ulp. -infinity at 0, NaN below.
[[nodiscard]] constexpr double log(double x) noexcept {
  if (!(x > 0) || !(x < detail::kInf)) return x == 0 ? -detail::kInf : x > 0 ? x : detail::kNaN;
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL;  // the mantissa is taken from there to the root of 2
  const double lift = x < std::numeric_limits<double>::min() ? 54.0 : 0.0;
  const auto bits = std::bit_cast<std::uint64_t>(lift > 0 ? x * 0x1p54 : x);
  const auto exponent = static_cast<std::int64_t>(bits - kRootHalf) >> 52;
  const double f = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52U)) - 1;
  const double k = static_cast<double>(exponent) - lift;
  return k * detail::kLn2High + (detail::twice_atanh(f / (2 + f)) + k * detail::kLn2Low);
}

/// log(1 + x), x > -1. Error: 3 ulp.
[[nodiscard]] constexpr double log1p(double x) noexcept {
  return x > -0.29 && x < 0.41 ? detail::twice_atanh(x / (2 + x)) : log(1 + x);
}

/// x^y, x >= 0; NaN below. Relative error: 2^-52 (1 + 2 |y log x|).
[[nodiscard]] constexpr double pow(double x, double y) noexcept {
  if (x == 0) return y > 0 ? 0.0 : y == 0 ? 1.0 : detail::kInf;
  return exp(y * log(x));
}

/// The angle of the point (x, y) from the x axis, from -π to π. Error: 2 ulp.
[[nodiscard]] inline double atan2(double y, double x) noexcept {
  constexpr std::array<double, 9> kEighths = {0.0,
                                              0.1243549945467614350,
                                              0.2449786631268641542,
                                              0.3587706702705722204,
                                              0.4636476090008061162,
                                              0.5585993153435624360,
                                              0.6435011087932843868,
                                              0.7188299996216245054,
                                              0.7853981633974483096};  // atan(i/8)
  constexpr auto kSeries = detail::inverse_odd<6>(true);
  const double ax = std::abs(x), ay = std::abs(y);
  const bool steep = ay > ax;
  double longer = select(steep, ay, ax), shorter = select(steep, ax, ay);
  if (shorter == detail::kInf) longer = shorter = 1;
  const double ratio = longer > 0 ? shorter / longer : longer + shorter;  // 0, or NaN
  if (ratio != ratio) return ratio;
  const auto eighth = static_cast<std::size_t>(ratio * 8 + 0.5);
  const double c = static_cast<double>(eighth) / 8;
  const double t = eighth == 0 ? ratio : (shorter - c * longer) / (longer + c * shorter), t2 = t * t;
  double angle = kEighths[eighth] + (t + t * t2 * detail::polynomial(t2, kSeries));
  angle = select(steep, std::numbers::pi / 2 - angle, angle);
  angle = select(std::signbit(x), std::numbers::pi - angle, angle);
  return std::copysign(angle, y);
}

/// Error: 4 ulp; NaN for |x| > 1.
[[nodiscard]] inline double acos(double x) noexcept { return 2 * atan2(std::sqrt(1 - x), std::sqrt(1 + x)); }

/// Error: 1 ulp.
[[nodiscard]] inline double cbrt(double x) noexcept {
  if (!(std::abs(x) < detail::kInf) || x == 0) return x;
  const double a = std::abs(x), y = exp(log(a) / 3);
  return std::copysign(y - (y - a / (y * y)) / 3, x);
}

/// The length of a vector, whatever its scale. Error: 3 ulp.
[[nodiscard]] inline double hypot(double x, double y, double z = 0) noexcept {
  const double largest = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (!(largest > 0) || largest == detail::kInf) return largest;
  return largest * std::sqrt(square(x / largest) + square(y / largest) + square(z / largest));
}

namespace detail {

/// With the terms that float32 asks for: a relative error of 1e-8 for x from -150 to 90.
[[nodiscard]] constexpr double short_exp(double x) noexcept {
  constexpr auto kSeries = inverse_factorials<6>(2, false);
  const std::int64_t k = nearest(x * std::numbers::log2e);
  const double r = x - static_cast<double>(k) * std::numbers::ln2;
  return (1 + (r + r * r * polynomial(r, kSeries))) * power_of_two(k);
}

}  // namespace detail

// Functions of float32 numbers. They compute in float64 with fewer terms. Error: 1 ulp of float32.
[[nodiscard]] constexpr float exp(float x) noexcept {
  if (!(x < 88.7228F)) return x != x ? x : kInfinity;
  return x < -104 ? 0.0F : static_cast<float>(detail::short_exp(static_cast<double>(x)));
}
[[nodiscard]] constexpr float log(float x) noexcept {
  if (!(x > 0) || !(x < kInfinity)) return static_cast<float>(log(static_cast<double>(x)));
  constexpr auto kSeries = detail::inverse_odd<5>(false);
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL;
  const auto bits = std::bit_cast<std::uint64_t>(static_cast<double>(x));
  const auto exponent = static_cast<std::int64_t>(bits - kRootHalf) >> 52;
  const double f = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52U)) - 1;
  const double s = f / (2 + f), s2 = s * s;
  return static_cast<float>(static_cast<double>(exponent) * std::numbers::ln2 +
                            2 * s * (1 + s2 * detail::polynomial(s2, kSeries)));
}
[[nodiscard]] constexpr float pow(float x, float y) noexcept {
  return static_cast<float>(pow(static_cast<double>(x), static_cast<double>(y)));
}
/// The error function, by two fits: erf(x)/x by x² below 1, and erfc(x)·exp(x²)/t by t = 1/(1 + x/2) above.
[[nodiscard]] constexpr float erf(float x) noexcept {
  constexpr std::array<double, 7> kNear = {1.1283791658483509,    -0.37612626666720331, 0.11283594715160218,
                                           -0.026854212010626412, 0.005189087423433974, -0.00080168642871658695,
                                           7.8758750626854883e-5};
  constexpr std::array<double, 8> kFar = {0.28212825094825577,  0.28150502325024771,  0.25096467875258704,
                                          0.16255383445528684,  0.099552155662066826, 0.028758455972948903,
                                          -0.18559088651971616, 0.08055507647168337};
  const double a = std::abs(static_cast<double>(x));
  if (a < 1) return static_cast<float>(static_cast<double>(x) * detail::polynomial(a * a, kNear));
  if (!(a < 4)) return x < 0 ? -1.0F : x > 0 ? 1.0F : x;
  const double t = 1 / (1 + 0.5 * a), beyond = detail::short_exp(-a * a) * t * detail::polynomial(t, kFar);
  return static_cast<float>(x < 0 ? beyond - 1 : 1 - beyond);
}

template <LaneNumber Real>
[[nodiscard]] Real exp(const Real& x) noexcept {
  return for_each_lane<Real>([](float lane) noexcept { return exp(lane); }, x);
}
template <LaneNumber Real>
[[nodiscard]] Real erf(const Real& x) noexcept {
  return for_each_lane<Real>([](float lane) noexcept { return erf(lane); }, x);
}

}  // namespace equaltime::elementary

namespace equaltime {

using elementary::SinCos;

[[nodiscard]] constexpr SinCos<float> sin_cos(float angle) noexcept {
  const auto [s, c] = elementary::sin_cos(static_cast<double>(angle));
  return {static_cast<float>(s), static_cast<float>(c)};
}

/// The same in float32 for |angle| <= π/4, by their series to below half an ulp of 1.
template <class Real>
[[nodiscard]] constexpr SinCos<Real> sin_cos_octant(Real x) noexcept {
  const Real s = x * x;
  const Real sine = x + x * s * (-1.0F / 6 + s * (1.0F / 120 + s * (-1.0F / 5040 + s * (1.0F / 362880))));
  const Real cosine = 1 + s * (-0.5F + s * (1.0F / 24 + s * (-1.0F / 720 + s * (1.0F / 40320))));
  return {sine, cosine};
}

/// Sine and cosine of a full turn times u, from 0 to 1, in the same way: to 1e-7.
template <class Real>
[[nodiscard]] constexpr SinCos<Real> sin_cos_turn(Real u) noexcept {
  const Real quarters = 4 * u;  // exact, as is its distance to the nearest quarter
  const auto nearest = Int<Real>(quarters + 0.5F);
  const auto [s, c] = sin_cos_octant<Real>((kPi / 2) * (quarters - Real(nearest)));
  const auto odd = (nearest & 1) != 0;
  const auto negated_if = [](Int<Real> quarter, Real x) noexcept {  // in the second half of four quarters
    return std::bit_cast<Real>(std::bit_cast<Bits<Real>>(x) ^ (Bits<Real>(quarter & 2) << 30));
  };
  return {negated_if(nearest, select(odd, c, s)), negated_if(nearest + 1, select(odd, s, c))};
}

}  // namespace equaltime
