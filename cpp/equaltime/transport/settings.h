// Settings: the strategy and the depth that a render follows; plain values, the same for every path.
#pragma once

#include <cstdint>

#include "equaltime/sampling/mis.h"
#include "equaltime/sampling/roulette.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/scene/lights.h"

namespace equaltime {

/// Sampling of direct light. `uniform` and `bsdf` use scattered rays only: uniform directions, or the BSDF's. `light`
/// uses shadow rays only. `mis` combines a shadow ray and the BSDF's ray at every vertex. `mixture` draws one direction
/// by either technique, and the path follows it.
enum class Technique : std::uint8_t { uniform, bsdf, light, mis, mixture };

[[nodiscard]] constexpr bool aims_at_lights(Technique technique) noexcept { return technique >= Technique::light; }
/// Whether a vertex draws the path's next direction by other means than the BSDF alone.
[[nodiscard]] constexpr bool replaces_bsdf_sampling(Technique technique) noexcept {
  return technique == Technique::uniform || technique == Technique::mixture;
}

class SplittingMap;

inline constexpr int kUnlimitedDepth = 0x7fffffff;

struct Settings {
  Technique technique = Technique::mis;
  Heuristic heuristic = Heuristic::power;  // of mis
  LightSelection light_selection = LightSelection::power;
  EnvironmentSampling environment_sampling = EnvironmentSampling::plain;
  Roulette roulette = Roulette::throughput;
  SamplerKind sampler = SamplerKind::lattice;
  float survival = 0.75F;                       // of the constant roulette, in (0, 1)
  int roulette_depth = 5;                       // the first depth at which a path may be ended at random
  int max_depth = kUnlimitedDepth;              // Mitsuba's: 1 sees emission only, 2 direct light too
  const SplittingMap* splitting_map = nullptr;  // numbers of copies, for the roulette `efficiency`
};

}  // namespace equaltime
