// The first two Sobol' dimensions with hashed nested uniform (Owen) scrambling, in closed form: no tables, no loops
// over bits. Indices and fractions are kept bit-reversed where that makes a step cheap; each function says so. The same
// code runs on one number and on four lanes at once.
#pragma once

#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"

namespace equaltime::sobol {

/// Four numbers worked on together (a vector extension of GCC and Clang, SSE on x86).
using Lanes = std::uint32_t __attribute__((vector_size(16)));
using FloatLanes = float __attribute__((vector_size(16)));

/// unit_float of each lane.
EQUALTIME_INLINE FloatLanes unit_floats(Lanes x) noexcept {
  using Ints = std::int32_t __attribute__((vector_size(16)));
  return __builtin_convertvector(reinterpret_cast<Ints>(x >> 8), FloatLanes) * 0x1p-24F;
}

/// Nested uniform scrambling of a bit-reversed fraction (Laine & Karras 2011; constants: Vegdahl 2021).
template <class U>
EQUALTIME_INLINE constexpr U scramble_reversed(U x, U seed) noexcept {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

/// Second Sobol' dimension, bit-reversed, from the index: Pascal's matrix modulo 2 as five butterfly steps (the
/// superset sums that Lucas' theorem gives for C(j, i) mod 2). `use` is all ones, or 0 in lanes that keep their index.
EQUALTIME_INLINE Lanes second_dimension_reversed(Lanes index, Lanes use) noexcept {
  index ^= (index >> 1) & (0x55555555U & use);
  index ^= (index >> 2) & (0x33333333U & use);
  index ^= (index >> 4) & (0x0f0f0f0fU & use);
  index ^= (index >> 8) & (0x00ff00ffU & use);
  index ^= (index >> 16) & (0x0000ffffU & use);
  return index;
}

EQUALTIME_INLINE Lanes reverse_bits(Lanes x) noexcept {
  using Bytes = std::uint8_t __attribute__((vector_size(16)));
  // Each byte, then the order of bytes.
#ifdef __clang__  // has no shuffle by a variable
  x = ((x >> 1) & 0x55555555U) | ((x & 0x55555555U) << 1);
  x = ((x >> 2) & 0x33333333U) | ((x & 0x33333333U) << 2);
  x = ((x >> 4) & 0x0f0f0f0fU) | ((x & 0x0f0f0f0fU) << 4);
  const Bytes bytes = reinterpret_cast<Bytes>(x);
#else
  // Halves of a byte by a table: the shuffle looks at four bits of a byte alone.
  constexpr Bytes reversed{0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  const Bytes low = __builtin_shuffle(reversed * 16, reinterpret_cast<Bytes>(x));
  const Bytes high = __builtin_shuffle(reversed, reinterpret_cast<Bytes>(x >> 4));
  const Bytes bytes = low | high;
#endif
  return reinterpret_cast<Lanes>(
      __builtin_shufflevector(bytes, bytes, 3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
}

// The three seeds of a slot, from its 64-bit hash: of the index's shuffle and of each dimension's scrambling.
constexpr std::uint32_t seed_shuffle(std::uint64_t hash) noexcept { return static_cast<std::uint32_t>(hash); }
template <LaneNumber Real = float>
constexpr Bits<Real> seed_x(Bits64<Real> hash) noexcept {
  return Bits<Real>(hash >> 32);
}
template <LaneNumber Real = float>
constexpr Bits<Real> seed_y(Bits64<Real> hash) noexcept {
  return Bits<Real>((hash * kGolden) >> 32);
}

/// Two points of two slots, as x, y, x, y: 32-bit fractions.
EQUALTIME_INLINE Lanes two_points(std::uint32_t reversed_index, std::uint64_t a, std::uint64_t b) noexcept {
  const std::uint32_t shuffle_a = seed_shuffle(a), shuffle_b = seed_shuffle(b);
  const Lanes base{reversed_index, reversed_index, reversed_index, reversed_index};
  Lanes index = reverse_bits(scramble_reversed(base, Lanes{shuffle_a, shuffle_a, shuffle_b, shuffle_b}));
  index = second_dimension_reversed(index, Lanes{0, ~0U, 0, ~0U});
  return reverse_bits(scramble_reversed(index, Lanes{seed_x(a), seed_y(a), seed_x(b), seed_y(b)}));
}

}  // namespace equaltime::sobol
