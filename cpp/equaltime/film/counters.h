// Counters: what a render did, counted per worker and added up in worker order.
#pragma once

#include <cstdint>

namespace equaltime {

struct Counters {
  std::uint64_t paths = 0;
  std::uint64_t rays = 0;         // nearest-hit queries: camera and scattered rays
  std::uint64_t shadow_rays = 0;  // occlusion queries
  std::uint64_t nonfinite = 0;    // samples that were NaN or infinite; none of them entered the film

  Counters& operator+=(const Counters& c) noexcept {
    paths += c.paths;
    rays += c.rays;
    shadow_rays += c.shadow_rays;
    nonfinite += c.nonfinite;
    return *this;
  }
};

}  // namespace equaltime
