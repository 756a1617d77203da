// Russian roulette: how likely a path goes on. The caller divides the throughput by it; it never enters a pdf.
// `albedo` and `throughput` let no weight of a BSDF's own directions grow. With `constant`, weights grow where the
// albedo exceeds it, and without a limit of depth the variance is infinite where the albedo's square does.
#pragma once

#include <algorithm>
#include <cstdint>

#include "equaltime/math/spectrum.h"

namespace equaltime {

enum class Roulette : std::uint8_t { none, constant, albedo, throughput, efficiency, automatic };

/// Probability of survival in [0, 1]. `beta` is the throughput with the radiance compression of refraction taken out;
/// `albedo` is called for that of the surface. There is no cap below 1: by throughput, a path of throughput 1 always
/// survives, so weights never grow and the variance stays finite.
template <class Albedo>
[[nodiscard]] constexpr float survival_probability(Roulette rule, float constant, const Spectrum& beta,
                                                   Albedo&& albedo) noexcept {
  switch (rule) {
    case Roulette::none:
      return 1.0F;
    case Roulette::constant:
      return constant;
    case Roulette::albedo:
      return std::min(1.0F, albedo().max_component());
    case Roulette::throughput:
    case Roulette::efficiency:  // which splits paths besides (transport/path_copies.h)
    case Roulette::automatic:   // either of these, once a pilot has decided (render/splitting.h)
      return std::min(1.0F, beta.max_component());
  }
  return 1.0F;
}

/// From this depth on, a path without a limit of depth is ended at random even where nothing is lost: glass holds light
/// by total reflection for ever.
inline constexpr int kLongPathDepth = 1024;

/// Probability of going on from a depth n of kLongPathDepth or more, beside the rule's: (n / (n + 1))², so that a path
/// gets to a depth d with (1024 / d)². It ends with probability 1, after 1024 more bounces on average. Weights grow
/// as d², which any loss makes up for: the variance stays finite for every albedo below 1, as it would not by a
/// constant.
[[nodiscard]] constexpr float long_path_survival(int depth) noexcept {
  const float n = static_cast<float>(depth), share = n / (n + 1);
  return share * share;
}

}  // namespace equaltime
