// Splitting: how many copies of a path are worth their rays, and whether splitting pays at all in a scene. Copies
// lessen the variance after the first scattering, and cost its rays; they do not change the variance before it.
// Variance times rays is least where the number of copies is proportional to the root of a copy's variance over its
// rays (Rath et al. 2022, "EARS", for one vertex of a path). A pilot measures both (render/splitting_pilot.h), so that
// they depend on the scene and the strategy alone.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "equaltime/base/stop.h"
#include "equaltime/transport/settings.h"
#include "equaltime/transport/splitting_map.h"

namespace equaltime {

struct Scene;

/// Numbers of copies that a pilot chose, and what they gain.
struct Splitting {
  SplittingMap splitting_map = SplittingMap::uniform(0);
  /// Logarithm of variance × rays with these copies over that without, every part of the pilot judging copies that the
  /// other parts chose; 0 where the pilot says nothing.
  double log_ratio = 0;
  std::uint64_t rays = 0, shadow_rays = 0;  // of the pilot
};

/// Renders a pilot and chooses the numbers of copies. The result does not depend on the number of threads. It has no
/// meaning if `stop` ended the pilot.
[[nodiscard]] Splitting estimate_splitting(const Scene& scene, const Settings& settings, unsigned threads, Stop& stop);

/// The roulette of a render.
struct RouletteDecision {
  Roulette roulette = Roulette::throughput;           // never automatic
  std::shared_ptr<const SplittingMap> splitting_map;  // null unless the roulette is `efficiency`
  std::optional<double> log_ratio;                    // as in Splitting; none without a pilot
  std::uint64_t rays = 0, shadow_rays = 0;            // of the pilot

  /// The settings with this roulette. They point to `splitting_map`, which must outlive them.
  [[nodiscard]] Settings applied(Settings settings) const noexcept;
};

/// Whether a pilot has something to say: the roulette is automatic, or splits paths and does not know how often.
[[nodiscard]] bool is_undecided(const Settings& settings) noexcept;

/// Decides by a pilot, if there is something to decide: splits paths where the roulette is efficiency and, where it is
/// automatic, if the pilot shows that this pays in seconds. Small films get no pilot, and no copies automatically. The
/// same for any number of threads. Means nothing if `stop` ended the pilot.
[[nodiscard]] RouletteDecision decide_roulette(const Scene& scene, const Settings& settings, unsigned threads,
                                               Stop& stop);

}  // namespace equaltime
