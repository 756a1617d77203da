// LobeWeights: how a plastic picks between its mirror and its body.
#pragma once

#include "equaltime/base/lanes.h"

namespace equaltime {

/// How much the mirror and the diffuse body scatter of the light that the interface gives each.
template <class Real>
struct LobeWeights {
  Real specular = 0, diffuse = 0;

  /// The probability of sampling the mirror, where the interface reflects and lets through so much.
  [[nodiscard]] Real specular_probability(Real reflected, Real entering) const noexcept {
    const Real mirror = specular * reflected, body = diffuse * entering;
    return where(mirror > 0, [&] { return mirror / (mirror + body); });
  }
};

}  // namespace equaltime
