// Named decisions: every random decision of a path owns a slot of two numbers, whatever other decisions are made.
// An effect that is absent leaves its slots unused and shifts nothing.
#pragma once

#include <cstdint>

#include "equaltime/base/lanes.h"

namespace equaltime {

/// Decisions taken once a path, before its first vertex.
enum class CameraDecision : std::uint32_t { pixel, lens, time, count };

/// Decisions taken at every vertex of a path.
enum class BounceDecision : std::uint32_t {
  light_pick,
  light_point,
  bsdf_lobe,
  bsdf_direction,
  roulette,
  technique,
  material,  // which part of a mixture
  medium,    // how far in a medium, and by which colour that is drawn
  count
};

/// The slot of a decision in one path, or in each lane: unique over all decisions and bounces.
template <LaneNumber Real>
struct BasicSlot {
  Bits<Real> index;
};
using Slot = BasicSlot<float>;

inline constexpr std::uint32_t kCameraSlots = 8;
inline constexpr std::uint32_t kBounceSlots = 16;  // half of them are free
static_assert(static_cast<std::uint32_t>(CameraDecision::count) <= kCameraSlots, "camera slots overlap bounce 0");
static_assert(static_cast<std::uint32_t>(BounceDecision::count) <= kBounceSlots, "slots of two bounces overlap");

template <LaneNumber Real = float>
constexpr BasicSlot<Real> slot(CameraDecision d) noexcept {
  return {static_cast<std::uint32_t>(d)};
}
/// `bounce` counts path vertices from 0, the first surface that the camera sees.
template <LaneNumber Real = float>
constexpr BasicSlot<Real> slot(BounceDecision d, Bits<Real> bounce) noexcept {
  return {kCameraSlots + bounce * kBounceSlots + static_cast<std::uint32_t>(d)};
}

}  // namespace equaltime
