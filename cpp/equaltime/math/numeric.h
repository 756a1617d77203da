// Constants and scalar functions that keep their accuracy: no absolute epsilon anywhere, only relative bounds.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <numbers>
#include <type_traits>

#include "equaltime/base/lanes.h"

/// For the few functions of the path loop whose arguments must stay in registers: a ray that goes through memory
/// between its making and its tracing costs more than many of the computations on it. For the same reason the structs
/// that live there are not declared const: GCC 12 keeps a const struct in memory.
#define EQUALTIME_INLINE [[gnu::always_inline]] inline

namespace equaltime {

inline constexpr float kPi = std::numbers::pi_v<float>;
inline constexpr float kTwoPi = 2 * kPi;
inline constexpr float kInvPi = std::numbers::inv_pi_v<float>;
inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1F;  // the largest float below 1
inline constexpr float kUnitRoundoff = 0x1p-24F;           // half a float32 ulp at 1

// Functions of one number, by the names that lanes have for them too.
template <std::floating_point T>
EQUALTIME_INLINE T sqrt(T x) noexcept {
  return std::sqrt(x);
}
template <std::floating_point T>
EQUALTIME_INLINE T abs(T x) noexcept {
  return std::abs(x);
}
template <std::floating_point T>
EQUALTIME_INLINE T copysign(T x, T sign) noexcept {
  return std::copysign(x, sign);
}
template <class T>
requires std::is_arithmetic_v<T>
constexpr T min(T a, T b) noexcept { return std::min(a, b); }
template <class T>
requires std::is_arithmetic_v<T>
constexpr T max(T a, T b) noexcept { return std::max(a, b); }

/// x within bounds, the bits of std::clamp.
template <LaneNumber Real>
constexpr Real clamp(Real x, std::type_identity_t<Real> low, std::type_identity_t<Real> high) noexcept {
  return min(max(x, low), high);
}
template <LaneNumber Real>
constexpr Real square(Real x) noexcept {
  return x * x;
}
template <LaneNumber Real>
inline Real safe_sqrt(Real x) noexcept {
  return sqrt(max(x, Real(0)));
}

/// One of two numbers by bits, for a choice that no processor can foresee: compilers would branch.
constexpr float select(bool first, float a, float b) noexcept {
  const std::uint32_t kept = 0 - static_cast<std::uint32_t>(first);
  return std::bit_cast<float>((std::bit_cast<std::uint32_t>(a) & kept) | (std::bit_cast<std::uint32_t>(b) & ~kept));
}
constexpr double select(bool first, double a, double b) noexcept {
  const std::uint64_t kept = 0 - static_cast<std::uint64_t>(first);
  return std::bit_cast<double>((std::bit_cast<std::uint64_t>(a) & kept) | (std::bit_cast<std::uint64_t>(b) & ~kept));
}

}  // namespace equaltime
