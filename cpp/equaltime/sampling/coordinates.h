// Which coordinates of a point of many dimensions the decisions of a path take: those of a lattice (sampling/lattice.h)
// and those of a Sobol' sequence (sampling/sobol.h).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "equaltime/sampling/dimensions.h"

namespace equaltime {

/// Vertices whose decisions have coordinates.
inline constexpr std::uint32_t kCoordinateBounces = 8;
inline constexpr std::uint32_t kCoordinates = 5 + 7 * kCoordinateBounces;
inline constexpr std::uint32_t kCoordinateSlots = kCameraSlots + kCoordinateBounces * kBounceSlots;

/// The first coordinate of each slot, counted from 1; 0: it has none, as all slots from kCoordinateSlots on. Two
/// decisions that never enter the same product share their coordinates: a vertex's light point and its BSDF direction
/// do, and its choices of a light and of a lobe.
inline constexpr std::array<std::uint8_t, kCoordinateSlots + 1> kFirstCoordinate = [] {
  std::array<std::uint8_t, kCoordinateSlots + 1> first{};
  std::uint8_t next = 1;
  const auto give = [&](Slot s, std::uint8_t numbers) {
    first[s.index] = next;
    next = static_cast<std::uint8_t>(next + numbers);
  };
  constexpr std::uint32_t bounces = kCoordinateBounces;
  give(slot(CameraDimension::pixel), 2);
  for (std::uint32_t b = 0; b < bounces; ++b) {
    first[slot(BounceDimension::light_point, b).index] = next;
    give(slot(BounceDimension::bsdf_direction, b), 2);
    first[slot(BounceDimension::light_pick, b).index] = next;
    give(slot(BounceDimension::bsdf_lobe, b), 1);
  }
  give(slot(CameraDimension::lens), 2);
  give(slot(CameraDimension::time), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDimension::roulette, b), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDimension::material, b), 1);
  for (std::uint32_t b = 0; b < bounces; ++b) give(slot(BounceDimension::medium, b), 2);
  return first;
}();
static_assert(kFirstCoordinate[slot(BounceDimension::medium, kCoordinateBounces - 1).index] + 1 == kCoordinates);

/// The first coordinate of a slot, or 0.
template <LaneNumber Real = float>
[[nodiscard]] constexpr Bits<Real> first_coordinate(BasicSlot<Real> s) noexcept {
  return lookup(kFirstCoordinate, min(s.index, Bits<Real>(kCoordinateSlots)));
}

}  // namespace equaltime
