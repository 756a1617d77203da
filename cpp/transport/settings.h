// Settings: the strategy and the depth that a render follows; plain values, the same for every path.
#pragma once

#include <cstdint>

#include "sampling/mis.h"
#include "sampling/roulette.h"
#include "sampling/sampler.h"
#include "scene/lights.h"

namespace equaltime {

/// How direct light is found: by the rays that the BSDF scatters, by rays sent to lights, or by both, weighted (MIS).
enum class Technique : std::uint8_t { bsdf, light, mis };

inline constexpr int kUnlimitedDepth = 0x7fffffff;

struct Settings {
  Technique technique = Technique::mis;
  Heuristic heuristic = Heuristic::power;
  LightSelection lights = LightSelection::power;
  Roulette roulette = Roulette::throughput;
  SamplerKind sampler = SamplerKind::sobol;
  float survival = 0.75F;           // of the constant roulette, in (0, 1)
  int roulette_depth = 5;           // the first depth at which a path may be ended at random
  int max_depth = kUnlimitedDepth;  // Mitsuba's: 1 sees emission only, 2 direct light too
};

}  // namespace equaltime
