// Bsdf: the closed set of models, and what each of them gives and takes. Directions are unit, local to the shading
// frame and point away from the surface; the frame's normal is on the side of wo, so wo.z > 0. Values include the
// cosine of wi; pdfs are per solid angle.
//
// A model is a template over Real (base/lanes.h), but for Principled, whose lobes part too often: kHasLanes tells it.
// Every model has
//   name, and needs (an effect), unless all kernels have the model;
//   is_delta: it scatters into discrete directions only; transmits: to the other side of the surface too;
//   picks_lobe: sample looks at u_lobe;
//   a constructor from its Description, and from the scene's BsdfTables if it has tables (bsdfs/tables.h);
//   Description, with its parameters in fields() (base/fields.h), and textured(), what textures may give
//   (bsdfs/texture_slots.h);
//   eval, sample, and albedo(wo, front): how much is scattered in all, exact or nearly, and 0 only if nothing is.
// A model may have
//   delta_probability(wo, front), if it has discrete directions and others: the probability that sample takes a
//   discrete one, which the smallest u_lobe do. Then eval leaves the discrete ones out, and its density includes this
//   choice; derive(), which is called after textures have given parameters; simpler(description), which returns another
//   model where the description is no more than that.
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
#include "equaltime/bsdfs/rough_diffuse.h"
#include "equaltime/bsdfs/rough_plastic.h"
#include "equaltime/bsdfs/thin_dielectric.h"

namespace equaltime {

using Bsdfs = TypeList<Diffuse<float>, RoughConductor<float>, Conductor<float>, Dielectric<float>,
                       ThinDielectric<float>, Plastic<float>, RoughPlastic<float>, RoughDielectric<float>, Principled,
                       PPlastic<float>, RoughDiffuse<float>>;
using Bsdf = Bsdfs::Variant;

// A BSDF is copied where textures give its parameters: what is large stands in the scene's tables.
static_assert(sizeof(Bsdf) <= 128);

/// Whether the model looks at the azimuth of directions, so that the shading frame's tangent matters.
[[nodiscard]] bool is_anisotropic(const Bsdf& bsdf) noexcept;

}  // namespace equaltime
