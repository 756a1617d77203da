// PhaseFunction: the closed set of laws by which media scatter. Each gives and takes what a BSDF does (bsdfs/bsdf.h),
// in a frame whose normal is wo, so that what looks for light at a surface does so in a medium too. Value and density
// are one: all that reaches a particle is scattered.
//
// Every model has `single_albedo`, which is the medium's: roulette asks for it; the weight of a collision has it
// already. Models of one law, which may be lobes of a blend, also have
//   a constructor from their Description, whose parameters are in fields() (base/fields.h); descriptions are compared.
#pragma once

#include "equaltime/base/type_list.h"
#include "equaltime/media/blended_phase.h"
#include "equaltime/media/henyey_greenstein.h"
#include "equaltime/media/isotropic.h"
#include "equaltime/media/rayleigh.h"
#include "equaltime/media/tabulated_phase.h"

namespace equaltime {

using PhaseLobes = TypeList<HenyeyGreenstein, IsotropicPhase, RayleighPhase, TabulatedPhase>;
using PhaseBlend = BlendedPhase<PhaseLobes>;
using PhaseFunctions = PhaseLobes::With<PhaseBlend>;
using PhaseFunction = PhaseFunctions::Variant;

}  // namespace equaltime
