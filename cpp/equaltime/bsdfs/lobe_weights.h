// LobeWeights: how a plastic picks between its specular lobe and its body.
#pragma once

#include "equaltime/base/lanes.h"

namespace equaltime {

/// How much the specular lobe and the diffuse body scatter of the light that the interface gives each.
template <class Real>
struct LobeWeights {
  Real specular = 0, diffuse = 0;

  /// The probability of sampling the specular lobe, where the interface reflects and lets through so much.
  [[nodiscard]] Real specular_probability(Real reflected, Real entering) const noexcept {
    const Real lobe = specular * reflected, body = diffuse * entering;
    return where(lobe > 0, [&] { return lobe / (lobe + body); });
  }
};

}  // namespace equaltime
