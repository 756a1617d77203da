// Integer mixing and bit patterns behind all random numbers: pure functions, no state.
#pragma once

#include <cstdint>
#include <type_traits>

#include "equaltime/base/lanes.h"

namespace equaltime {

/// 2^64 over the golden ratio: an odd number without a pattern, for hashes.
inline constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;

/// Finaliser with full avalanche (Stafford's variant 13, as in SplitMix64; Steele, Lea & Flood 2014).
/// U: 64 bits, or lanes of them.
template <class U = std::uint64_t>
constexpr U mix64(std::type_identity_t<U> x) noexcept {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// U: 32 bits, or lanes of them.
template <class U = std::uint32_t>
constexpr U reverse_bits(std::type_identity_t<U> x) noexcept {
  x = ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  x = ((x >> 8) & 0x00ff00ffU) | ((x & 0x00ff00ffU) << 8);
  return (x >> 16) | (x << 16);
}

/// The 24 leading bits as a float in [0, 1): exact, never 1.
template <LaneNumber Real = float>
constexpr Real unit_float(Bits<Real> x) noexcept {
  return Real(x >> 8) * 0x1p-24F;
}

}  // namespace equaltime
