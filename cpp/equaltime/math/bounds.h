// Bounds: the smallest box along the axes around points, in float64.
#pragma once

#include "equaltime/math/vector.h"

namespace equaltime {

struct Bounds {
  Vec3d lo{1e308, 1e308, 1e308}, hi{-1e308, -1e308, -1e308};

  void include(const Vec3d& p) noexcept { lo = min(lo, p), hi = max(hi, p); }
  void include(const Bounds& b) noexcept { lo = min(lo, b.lo), hi = max(hi, b.hi); }
  [[nodiscard]] bool empty() const noexcept { return lo.x > hi.x; }
  [[nodiscard]] Vec3d extent() const noexcept { return hi - lo; }
  [[nodiscard]] Vec3d center() const noexcept { return (lo + hi) * 0.5; }
};

/// Whether two boxes have a point in common.
[[nodiscard]] inline bool touch(const Bounds& a, const Bounds& b) noexcept {
  return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z &&
         b.lo.z <= a.hi.z;
}

}  // namespace equaltime
