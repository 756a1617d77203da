#include "equaltime/bsdfs/bsdf.h"

namespace equaltime {

bool is_anisotropic(const Bsdf& bsdf) noexcept {
  return visit<kAllEffects>(bsdf, [](const auto& model) noexcept {
    if constexpr (requires { model.distribution; })
      return model.distribution.anisotropic();
    else
      return false;
  });
}

}  // namespace equaltime
