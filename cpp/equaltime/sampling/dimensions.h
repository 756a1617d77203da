// Which dimensions of a low-discrepancy point the decisions of a path take: of a lattice (sampling/lattice.h) or of a
// Sobol' sequence (sampling/sobol.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"
#include "equaltime/sampling/decisions.h"

namespace equaltime {

/// Vertices whose decisions have dimensions.
inline constexpr std::uint32_t kDimensionBounces = 8;
/// Two for the pixel, two for the lens, one for the time, and seven a vertex.
inline constexpr std::uint32_t kDimensions = 5 + 7 * kDimensionBounces;
inline constexpr std::uint32_t kDimensionSlots = kCameraSlots + kDimensionBounces * kBounceSlots;

/// The first dimension of each slot, counted from 1; 0: it has none, as all slots from kDimensionSlots on. Two
/// decisions share dimensions if no contribution of a path contains both: a vertex's light point and its BSDF direction
/// do, and its choices of a light and of a lobe.
inline constexpr std::array<std::uint8_t, kDimensionSlots + 1> kFirstDimension = [] {
  std::array<std::uint8_t, kDimensionSlots + 1> first{};
  std::uint8_t next = 1;
  const auto give = [&](Slot s, std::uint8_t numbers) {
    first[s.index] = next;
    next = static_cast<std::uint8_t>(next + numbers);
  };
  constexpr std::uint32_t bounces = kDimensionBounces;
  give(slot(CameraDecision::pixel), 2);
  for (std::uint32_t b = 0; b < bounces; ++b) {
    first[slot(BounceDecision::light_point, b).index] = next;
    give(slot(BounceDecision::bsdf_direction, b), 2);
    first[slot(BounceDecision::light_pick, b).index] = next;
    give(slot(BounceDecision::bsdf_lobe, b), 1);
  }
  give(slot(CameraDecision::lens), 2);
  give(slot(CameraDecision::time), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDecision::roulette, b), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDecision::material, b), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDecision::medium, b), 2);
  return first;
}();
static_assert(kFirstDimension[slot(BounceDecision::medium, kDimensionBounces - 1).index] + 1 == kDimensions);

/// The first dimension of a slot, or 0.
template <LaneNumber Real = float>
[[nodiscard]] constexpr Bits<Real> first_dimension(BasicSlot<Real> s) noexcept {
  return lookup(kFirstDimension, min(s.index, Bits<Real>(kDimensionSlots)));
}

/// Seeds of the two dimensions of a slot, from the slot's hash: of a lattice's shift, or of Sobol' points' scrambling.
template <LaneNumber Real = float>
[[nodiscard]] constexpr Bits<Real> seed_x(Bits64<Real> hash) noexcept {
  return Bits<Real>(hash >> 32);
}
template <LaneNumber Real = float>
[[nodiscard]] constexpr Bits<Real> seed_y(Bits64<Real> hash) noexcept {
  return Bits<Real>((hash * kGolden) >> 32);
}

}  // namespace equaltime
