// Sobol' points with hashed nested uniform (Owen) scrambling. Decisions with dimensions (sampling/dimensions.h) share
// one point of many dimensions. Other decisions are padded: each has the first two dimensions, in an order of its own.
// Indices and fractions are kept bit-reversed where that makes a step cheap; each function says so.
#pragma once

#include <bit>
#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/dimensions.h"
#include "equaltime/sampling/sobol_directions.h"

namespace equaltime::sobol {

/// Nested uniform scrambling of a bit-reversed fraction (Laine & Karras 2011; constants: Vegdahl 2021).
EQUALTIME_INLINE constexpr std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) noexcept {
  x ^= x * 0x3d20adeaU;
  x += seed;
  x *= (seed >> 16) | 1U;
  x ^= x * 0x05526c56U;
  x ^= x * 0x53a22864U;
  return x;
}

/// A coordinate of a point, in 32 bits: `dimension` counts from 1.
[[nodiscard]] inline std::uint32_t coordinate(std::uint32_t reversed_index, std::uint32_t dimension,
                                              std::uint32_t seed) noexcept {
  std::uint32_t x = 0;
  for (std::uint32_t bits = reversed_index; bits != 0; bits &= bits - 1)
    x ^= kReversedDirections[dimension - 1][static_cast<std::size_t>(std::countr_zero(bits))];
  return reverse_bits(scramble_reversed(x, seed));
}

/// Permutes the samples within each 16 at random, as a slot's hash chooses; takes and returns a bit-reversed index.
/// Nested scrambling of the index alone leaves samples 2k and 2k + 1 beside each other in every slot. Any two slots
/// then change together within such a pair, which doubles the variance of their coarsest interaction.
[[nodiscard]] constexpr std::uint32_t permute_in_16(std::uint32_t reversed_index, std::uint64_t hash) noexcept {
  constexpr std::uint32_t kBlock = 0x0fff'ffffU;  // which 16, in all but the leading four bits
  std::uint64_t random = mix64(hash + (reversed_index & kBlock));
  std::uint32_t place = reversed_index >> 28;
  for (int round = 0; round < 6; ++round, random >>= 8) {  // each step is one-to-one
    place = ((place ^ static_cast<std::uint32_t>(random)) * (static_cast<std::uint32_t>(random >> 4) | 1U)) & 15U;
    place ^= place >> 2;
  }
  return (place << 28) | (reversed_index & kBlock);
}

/// The index of a sample in the order of a padded slot: nested scrambling of a bit-reversed index.
[[nodiscard]] constexpr std::uint32_t shuffled_index(std::uint32_t reversed_index, std::uint64_t hash) noexcept {
  return reverse_bits(scramble_reversed(reversed_index, static_cast<std::uint32_t>(hash)));
}

/// A padded slot's first number, in 32 bits, from the shuffled index.
[[nodiscard]] constexpr std::uint32_t padded_x(std::uint32_t index, std::uint64_t hash) noexcept {
  return reverse_bits(scramble_reversed(index, seed_x(hash)));
}

/// Its second number: Pascal's matrix modulo 2 as five butterfly steps (the superset sums that Lucas' theorem gives for
/// C(j, i) mod 2) makes the second dimension, bit-reversed, from the index.
[[nodiscard]] constexpr std::uint32_t padded_y(std::uint32_t index, std::uint64_t hash) noexcept {
  index ^= (index >> 1) & 0x55555555U;
  index ^= (index >> 2) & 0x33333333U;
  index ^= (index >> 4) & 0x0f0f0f0fU;
  index ^= (index >> 8) & 0x00ff00ffU;
  index ^= (index >> 16) & 0x0000ffffU;
  return reverse_bits(scramble_reversed(index, seed_y(hash)));
}

}  // namespace equaltime::sobol
