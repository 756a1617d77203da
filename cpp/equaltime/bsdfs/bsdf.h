// Bsdf: the closed set of models, and what each of them gives and takes. Directions are unit, local to the shading
// frame and point away from the surface; the frame's normal is on the side of wo, so wo.z > 0. Values include the
// cosine of wi; pdfs are per solid angle. Besides eval and sample there is albedo(wo, front): how much is scattered in
// all, exact or nearly, 0 only if nothing. Each model says whether it is_delta (scatters into discrete directions
// only), whether it transmits (to the other side of the surface), and whether it picks_lobe (sample looks at u_lobe).
// One that scatters into discrete directions and others has discrete_share(wo, front) too: the probability that sample
// takes a discrete one, which are those of the smallest u_lobe; eval is of the others alone, and their density includes
// that of not taking a discrete one. It has a Description, whose parameters are its `fields`, and `textured`, what
// textures may give (bsdfs/fields.h): then it may have derive(), which is called when they have. Where a description
// says that it is no more than another model, it may have simpler(description), which is that one.
#pragma once

#include "equaltime/base/type_list.h"
#include "equaltime/bsdfs/conductor.h"
#include "equaltime/bsdfs/dielectric.h"
#include "equaltime/bsdfs/diffuse.h"
#include "equaltime/bsdfs/plastic.h"
#include "equaltime/bsdfs/pplastic.h"
#include "equaltime/bsdfs/principled.h"
#include "equaltime/bsdfs/rough_conductor.h"
#include "equaltime/bsdfs/rough_dielectric.h"
#include "equaltime/bsdfs/rough_plastic.h"
#include "equaltime/bsdfs/thin_dielectric.h"

namespace equaltime {

using Bsdfs = TypeList<Diffuse, RoughConductor, Conductor, Dielectric, ThinDielectric, Plastic, RoughPlastic,
                       RoughDielectric, Principled, PPlastic>;
using Bsdf = Bsdfs::Variant;

/// Whether the model looks at the azimuth of directions, so that the shading frame's tangent matters.
[[nodiscard]] bool is_anisotropic(const Bsdf& bsdf) noexcept;

}  // namespace equaltime
