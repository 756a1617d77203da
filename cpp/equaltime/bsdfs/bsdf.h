// Bsdf: the closed set of models, and the one switch over it that a kernel's effects prune.
#pragma once

#include <utility>
#include <variant>

#include "equaltime/base/effects.h"
#include "equaltime/bsdfs/conductor.h"
#include "equaltime/bsdfs/dielectric.h"
#include "equaltime/bsdfs/diffuse.h"
#include "equaltime/bsdfs/plastic.h"
#include "equaltime/bsdfs/principled.h"
#include "equaltime/bsdfs/rough_conductor.h"
#include "equaltime/bsdfs/rough_dielectric.h"
#include "equaltime/bsdfs/rough_plastic.h"
#include "equaltime/bsdfs/thin_dielectric.h"
#include "equaltime/media/blended_phase.h"
#include "equaltime/media/phase.h"

namespace equaltime {

using Bsdf = std::variant<Diffuse, RoughConductor, Conductor, Dielectric, ThinDielectric, Plastic, RoughPlastic,
                          RoughDielectric, Principled, Phase, BlendedPhase>;

/// Whether the model looks at the azimuth of directions, so that the shading frame's tangent matters.
[[nodiscard]] bool is_anisotropic(const Bsdf& bsdf) noexcept;

/// Calls f with the model that `bsdf` holds. E (base/effects.h) says which models the scene can hold at all; the
/// others cost nothing.
template <Effects E, class F>
[[nodiscard]] EQUALTIME_INLINE auto visit(const Bsdf& bsdf, F&& f) noexcept {
  if constexpr (E.rough_conductors)
    if (const auto* model = std::get_if<RoughConductor>(&bsdf)) return f(*model);
  if constexpr (E.specular) {
    if (const auto* model = std::get_if<Conductor>(&bsdf)) return f(*model);
    if (const auto* model = std::get_if<Dielectric>(&bsdf)) return f(*model);
    if (const auto* model = std::get_if<ThinDielectric>(&bsdf)) return f(*model);
  }
  if constexpr (E.media)
    if (const auto* model = std::get_if<Phase>(&bsdf)) return f(*model);
  if constexpr (E.phase_blends)
    if (const auto* model = std::get_if<BlendedPhase>(&bsdf)) return f(*model);
  if constexpr (E.principled)
    if (const auto* model = std::get_if<Principled>(&bsdf)) return f(*model);
  if constexpr (E.rough_dielectrics)
    if (const auto* model = std::get_if<RoughDielectric>(&bsdf)) return f(*model);
  if constexpr (E.layered) {
    if (const auto* model = std::get_if<RoughPlastic>(&bsdf)) return f(*model);
    if (const auto* model = std::get_if<Plastic>(&bsdf)) return f(*model);
  }
  return f(*std::get_if<Diffuse>(&bsdf));
}

}  // namespace equaltime
