// Bsdf: the closed set of models, and the one switch over it that a kernel's effects prune.
#pragma once

#include <utility>
#include <variant>

#include "scene/blended_phase.h"
#include "scene/conductor.h"
#include "scene/dielectric.h"
#include "scene/diffuse.h"
#include "scene/phase.h"
#include "scene/plastic.h"
#include "scene/principled.h"
#include "scene/rough_conductor.h"
#include "scene/rough_dielectric.h"
#include "scene/rough_plastic.h"
#include "scene/thin_dielectric.h"

namespace equaltime {

using Bsdf = std::variant<Diffuse, RoughConductor, Conductor, Dielectric, ThinDielectric, Plastic, RoughPlastic,
                          RoughDielectric, Principled, Phase, BlendedPhase>;

[[nodiscard]] Bsdf make_bsdf(const BsdfDescription& description);

/// Whether the model looks at the azimuth of directions, so that the shading frame's tangent matters.
[[nodiscard]] bool is_anisotropic(const Bsdf& bsdf) noexcept;

/// Calls f with the model that `bsdf` holds. E (transport/effects.h) says which models the scene can hold at all; the
/// others cost nothing.
template <auto E, class F>
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
