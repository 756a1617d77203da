// Principled: Burley's diffuse, metallic, glassy and coated material (Disney 2012, 2015) with Mitsuba's parameters and
// formulas. From the front: a diffuse lobe with retro-reflection, blended to a flat look of subsurface light; sheen;
// the main lobe, GGX facets that reflect as a dielectric, tinted, or a metal, and refract as glass; a clear coat. From
// behind only the glass is seen. As Mitsuba has it, facets whose index is 1 reflect nothing at all, not even as metal.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

/// Mitsuba's words; ior is interior over exterior.
struct PrincipledDescription {
  Vec3d base_color{0.5, 0.5, 0.5};
  double roughness = 0.5, anisotropic = 0, metallic = 0, spec_trans = 0, ior = 1.5, spec_tint = 0, sheen = 0,
         sheen_tint = 0, flatness = 0, clearcoat = 0, clearcoat_gloss = 0;
};

struct Principled {
  using Description = PrincipledDescription;
  static constexpr const char* name = "principled";
  static constexpr bool Effects::*needs = &Effects::principled;
  static constexpr bool is_delta = false;
  static constexpr bool picks_lobe = true;
  bool transmits;
  Spectrum base_color;
  float roughness, anisotropic, metallic, spec_trans, ior, spec_tint, sheen, sheen_tint, flatness, clearcoat,
      clearcoat_gloss;
  Microfacet<float> distribution;  // of the main lobe; follows from roughness and anisotropy

  explicit Principled(const PrincipledDescription& d) noexcept;
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"base_color", &Description::base_color, kShare},
                      Field{"roughness", &Description::roughness, kShare},
                      Field{"anisotropic", &Description::anisotropic, kShare},
                      Field{"metallic", &Description::metallic, kShare},
                      Field{"spec_trans", &Description::spec_trans, kShare},
                      Field{"ior", &Description::ior, kIor},
                      Field{"spec_tint", &Description::spec_tint, kShare},
                      Field{"sheen", &Description::sheen, kShare},
                      Field{"sheen_tint", &Description::sheen_tint, kShare},
                      Field{"flatness", &Description::flatness, kShare},
                      Field{"clearcoat", &Description::clearcoat, kShare},
                      Field{"clearcoat_gloss", &Description::clearcoat_gloss, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("base_color", &Principled::base_color),
                      number_slot("roughness", &Principled::roughness),
                      number_slot("anisotropic", &Principled::anisotropic, true),
                      number_slot("metallic", &Principled::metallic),
                      number_slot("spec_trans", &Principled::spec_trans),
                      number_slot("spec_tint", &Principled::spec_tint),
                      number_slot("sheen", &Principled::sheen),
                      number_slot("sheen_tint", &Principled::sheen_tint),
                      number_slot("flatness", &Principled::flatness),
                      number_slot("clearcoat", &Principled::clearcoat),
                      number_slot("clearcoat_gloss", &Principled::clearcoat_gloss)};
  }

  [[nodiscard]] BsdfValue<float> eval(const Vec3f& wo, const Vec3f& wi, bool front) const noexcept;
  [[nodiscard]] Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double u_lobe,
                                                   Point2f u) const noexcept;
  /// Nearly, and 0 only if nothing: the lobes' own at the angle of wo.
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool front) const noexcept;

  /// Computes all that follows from the parameters, which textures may give.
  void derive() noexcept;

 private:
  /// The probabilities of drawing from each lobe.
  struct Lobes {
    float diffuse, clearcoat, facets;
  };
  /// What the facets at an angle of incidence, of the cosine c, reflect and refract.
  struct Facets {
    Spectrum reflectance, transmittance;
    float refracting;  // the probability that a sample is refracted
  };

  [[nodiscard]] Lobes lobes(const Vec3f& wo, bool front) const noexcept;
  [[nodiscard]] Facets facets(float c, float eta, float reflectance, bool front) const noexcept;
  [[nodiscard]] BsdfValue<float> eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m, bool front) const noexcept;
  [[nodiscard]] Spectrum diffuse(const Vec3f& wo, const Vec3f& wi, float c) const noexcept;
  [[nodiscard]] Spectrum schlick(const Spectrum& r0, float c) const noexcept;

  Spectrum tint_;            // the base colour at a luminance of 1
  Spectrum glass_;           // what the refracted light is multiplied by
  float body_, glassiness_;  // weights of the diffuse lobe and of refraction
  float coat_alpha_;
};

}  // namespace equaltime
