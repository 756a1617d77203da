// One rank-1 lattice for the numbers of the first eight vertices of a path, in van der Corput order. Point i has the
// coordinate i' z / 2^32 + shift modulo 1: i' is the bit-reversed index, and z is the decision's component of the
// vector. Any 2^k points from a multiple of 2^k on are a shifted lattice. Each pixel and slot has a random shift of its
// own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/dimensions.h"
#include "equaltime/sampling/lattice_vector.h"

namespace equaltime::lattice {

inline constexpr std::uint32_t kSlots = kCameraSlots + kBounces * kBounceSlots;

/// The first component of each slot, counted from 1; 0: it has none, as all slots from kSlots on. Two decisions that
/// never enter the same product share their components: a vertex's light point and its BSDF direction do, and its
/// choices of a light and of a lobe.
inline constexpr std::array<std::uint8_t, kSlots + 1> kFirst = [] {
  std::array<std::uint8_t, kSlots + 1> first{};
  std::uint8_t next = 1;
  const auto give = [&](Slot s, std::uint8_t components) {
    first[s.index] = next;
    next = static_cast<std::uint8_t>(next + components);
  };
  give(slot(CameraDimension::pixel), 2);
  for (std::uint32_t b = 0; b < kBounces; ++b) {
    first[slot(BounceDimension::light_point, b).index] = next;
    give(slot(BounceDimension::bsdf_direction, b), 2);
    first[slot(BounceDimension::light_pick, b).index] = next;
    give(slot(BounceDimension::bsdf_lobe, b), 1);
  }
  give(slot(CameraDimension::lens), 2);
  give(slot(CameraDimension::time), 1);
  for (std::uint32_t b = 0; b < kBounces; ++b) give(slot(BounceDimension::roulette, b), 1);
  for (std::uint32_t b = 0; b < kBounces; ++b) give(slot(BounceDimension::material, b), 1);
  for (std::uint32_t b = 0; b < kBounces; ++b) give(slot(BounceDimension::medium, b), 2);
  return first;
}();
static_assert(kFirst[slot(BounceDimension::medium, kBounces - 1).index] + 1 == std::size(kVector));

/// The vector's components, from index 1 on. Index 0 holds a 0 for slots without components.
inline constexpr auto kComponents = [] {
  std::array<std::uint32_t, std::size(kVector) + 1> components{};
  std::copy(std::begin(kVector), std::end(kVector), components.begin() + 1);
  return components;
}();

/// Whether a slot has components. Others are padded: Sobol' points of their own, by `padded_index`.
template <LaneNumber Real = float>
[[nodiscard]] constexpr Mask<Real> has(BasicSlot<Real> s) noexcept {
  return lookup(kFirst, min(s.index, Bits<Real>(kSlots))) != 0;
}

/// A coordinate of a point, in 32 bits: `component` counts from the first of the slot.
template <class Real>
[[nodiscard]] constexpr Bits<Real> coordinate(Bits<Real> reversed_index, BasicSlot<Real> s, std::uint32_t component,
                                              Bits<Real> shift) noexcept {
  const Bits<Real> first = lookup(kFirst, min(s.index, Bits<Real>(kSlots)));
  return reversed_index * lookup(kComponents, first + component) + shift;
}

/// Permutes the samples within each 16 at random, as `hash` chooses; takes and returns a bit-reversed index. Nested
/// scrambling of the index alone leaves samples 2k and 2k + 1 beside each other in every slot. Any two slots then
/// change together within such a pair, which doubles the variance of their coarsest interaction.
[[nodiscard]] inline std::uint32_t padded_index(std::uint32_t reversed_index, std::uint64_t hash) noexcept {
  constexpr std::uint32_t kBlock = 0x0fff'ffffU;  // which 16, in all but the leading four bits
  std::uint64_t random = mix64(hash + (reversed_index & kBlock));
  std::uint32_t place = reversed_index >> 28;
  for (int round = 0; round < 6; ++round, random >>= 8) {  // each step is one-to-one
    place = ((place ^ static_cast<std::uint32_t>(random)) * (static_cast<std::uint32_t>(random >> 4) | 1U)) & 15U;
    place ^= place >> 2;
  }
  return (place << 28) | (reversed_index & kBlock);
}

}  // namespace equaltime::lattice
