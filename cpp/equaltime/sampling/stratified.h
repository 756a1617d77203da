// Jittered strata for any number of samples: of every 4^k samples in a row of a replicate, counted from the first, each
// lies in a cell of its own of a grid of 2^k by 2^k over the unit square, for every k at once; within its cell it is
// uniform. These are the nested strata of one scrambled number, whose bits go to the two coordinates in turn, so that
// unlike a Sobol' point neither coordinate is as evenly spread by itself as both together are.
#pragma once

#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/sampling/sobol.h"

namespace equaltime::stratified {

/// Every second bit, from the lowest on, moved together into the lower half.
constexpr std::uint32_t every_second_bit(std::uint32_t x) noexcept {
  x &= 0x55555555U;
  x = (x | (x >> 1)) & 0x33333333U;
  x = (x | (x >> 2)) & 0x0f0f0f0fU;
  x = (x | (x >> 4)) & 0x00ff00ffU;
  return (x | (x >> 8)) & 0x0000ffffU;
}

/// Two fractions of 32 bits, x in the upper half: sixteen bits each that place the cell, then sixteen by hashing.
/// `hash` is the slot's. Out of line: within the path loop it cost the other samplers 2 %.
[[nodiscard, gnu::noinline]] inline std::uint64_t bits_2d(std::uint32_t reversed_index, std::uint64_t hash) noexcept {
  const std::uint32_t place = sobol::padded_x(sobol::shuffled_index(reversed_index, hash), hash);
  const std::uint64_t x = every_second_bit(place >> 1), y = every_second_bit(place);
  const std::uint64_t within = mix64(hash ^ mix64(reversed_index));
  return (x << 48) | (within >> 32 & 0xffff) << 32 | (y << 16) | (within & 0xffff);
}

}  // namespace equaltime::stratified
