// Russian roulette: how likely a path goes on. The caller divides the throughput by it; it never enters a pdf.
#pragma once

#include <algorithm>
#include <cstdint>

#include "math/spectrum.h"

namespace equaltime {

enum class Roulette : std::uint8_t { none, throughput };

/// Probability of survival in [0, 1]. `beta` is the throughput with the radiance compression of refraction taken out.
/// There is no cap below 1: a path of throughput 1 always survives, so weights never grow and the variance stays
/// finite.
[[nodiscard]] constexpr float survival_probability(Roulette rule, const Spectrum& beta) noexcept {
  switch (rule) {
    case Roulette::none:
      return 1.0F;
    case Roulette::throughput:
      return std::min(1.0F, beta.max_component());
  }
  return 1.0F;
}

}  // namespace equaltime
