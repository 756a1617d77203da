// Integer mixing and bit patterns behind all random numbers: pure functions, no state.
#pragma once

#include <cstdint>

namespace equaltime {

/// Finaliser with full avalanche (Stafford's variant 13, as in SplitMix64; Steele, Lea & Flood 2014).
constexpr std::uint64_t mix64(std::uint64_t x) noexcept {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

constexpr std::uint32_t reverse_bits(std::uint32_t x) noexcept {
  x = ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  return __builtin_bswap32(x);
}

/// The 24 leading bits as a float in [0, 1): exact, never 1.
constexpr float unit_float(std::uint32_t x) noexcept { return static_cast<float>(x >> 8) * 0x1p-24F; }

}  // namespace equaltime
