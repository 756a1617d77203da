// Bsdf: the closed set of models.
#pragma once

#include "equaltime/base/type_list.h"
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

using Bsdfs = TypeList<Diffuse, RoughConductor, Conductor, Dielectric, ThinDielectric, Plastic, RoughPlastic,
                       RoughDielectric, Principled, Phase, BlendedPhase>;
using Bsdf = Bsdfs::Variant;

/// Whether the model looks at the azimuth of directions, so that the shading frame's tangent matters.
[[nodiscard]] bool is_anisotropic(const Bsdf& bsdf) noexcept;

}  // namespace equaltime
