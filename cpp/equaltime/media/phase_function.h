// PhaseFunction: the closed set of laws by which media scatter. Each gives and takes what a BSDF does (bsdfs/bsdf.h),
// in a frame whose normal is wo, so that what looks for light at a surface does so in a medium too.
#pragma once

#include "equaltime/base/type_list.h"
#include "equaltime/media/blended_phase.h"
#include "equaltime/media/henyey_greenstein.h"
#include "equaltime/media/isotropic.h"

namespace equaltime {

using PhaseFunctions = TypeList<HenyeyGreenstein, IsotropicPhase, BlendedPhase>;
using PhaseFunction = PhaseFunctions::Variant;

}  // namespace equaltime
