// What every BSDF gives and takes. Directions are unit, local to the shading frame and point away from the surface;
// the frame's normal is on the side of wo, so wo.z > 0. Values include the cosine of wi; pdfs are per solid angle.
// Besides eval and sample there is albedo(wo, front): how much is scattered in all, exact or nearly, 0 only if nothing.
// Each model says whether it is_delta (scatters into discrete directions only), whether it transmits (to the other side
// of the surface), and whether it picks_lobe (sample looks at u_lobe). One that scatters into discrete directions and
// others has discrete_share(wo, front) too: the probability that sample takes a discrete one, which are those of the
// smallest u_lobe; eval is of the others alone, and their density includes that of not taking a discrete one.
#pragma once

#include <cstdint>

#include "equaltime/sampling/scattering.h"

namespace equaltime {

/// What a texture may give to a model, which takes it by `set`; a model leaves alone what it does not have. A parameter
/// that is one number is given a grey.
enum class BsdfParameter : std::uint8_t {
  reflectance,
  diffuse_reflectance,
  specular_reflectance,
  specular_transmittance,
  eta,
  k,
  alpha,
  alpha_u,
  alpha_v,
  base_color,
  roughness,
  anisotropic,
  metallic,
  spec_trans,
  spec_tint,
  sheen,
  sheen_tint,
  flatness,
  clearcoat,
  clearcoat_gloss,
  weight  // of a mixture
};
inline constexpr const char* kBsdfParameterNames[] = {"reflectance",
                                                      "diffuse_reflectance",
                                                      "specular_reflectance",
                                                      "specular_transmittance",
                                                      "eta",
                                                      "k",
                                                      "alpha",
                                                      "alpha_u",
                                                      "alpha_v",
                                                      "base_color",
                                                      "roughness",
                                                      "anisotropic",
                                                      "metallic",
                                                      "spec_trans",
                                                      "spec_tint",
                                                      "sheen",
                                                      "sheen_tint",
                                                      "flatness",
                                                      "clearcoat",
                                                      "clearcoat_gloss",
                                                      "weight"};

[[nodiscard]] constexpr bool is_number(BsdfParameter p) noexcept {
  return (p >= BsdfParameter::alpha && p <= BsdfParameter::alpha_v) || p >= BsdfParameter::roughness;
}

}  // namespace equaltime
