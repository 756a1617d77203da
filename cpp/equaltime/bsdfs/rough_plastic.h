// Rough plastic: microfacets of a dielectric over a diffuse body. Mitsuba's model: what enters the body and leaves it
// is the share of light that one refraction by microfacets lets through.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/plastic.h"
#include "equaltime/bsdfs/tables.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct RoughPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
  bool nonlinear = false;  // see PlasticDescription
};

struct RoughPlastic {
  using Description = RoughPlasticDescription;
  static constexpr const char* name = "roughplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet distribution;
  float ior;  // interior over exterior
  bool nonlinear;
  Spectrum diffuse_reflectance, specular_reflectance;

  RoughPlastic(const Description& d, BsdfTables& tables)
      : distribution(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.alpha)),
        ior(static_cast<float>(d.ior)),
        nonlinear(d.nonlinear),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        transmittance_(&tables.rough_transmittance(d.distribution, static_cast<float>(d.alpha), ior)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &RoughPlasticDescription::distribution},
                      Field{"alpha", &RoughPlasticDescription::alpha, kRoughness},
                      Field{"ior", &RoughPlasticDescription::ior, kIor},
                      Field{"diffuse_reflectance", &RoughPlasticDescription::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &RoughPlasticDescription::specular_reflectance, kShare},
                      Field{"nonlinear", &RoughPlasticDescription::nonlinear}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("diffuse_reflectance", &RoughPlastic::diffuse_reflectance),
                      color_slot("specular_reflectance", &RoughPlastic::specular_reflectance)};
  }

  [[nodiscard]] BsdfValue eval(const Vec3f& wo, const Vec3f& wi, bool) const noexcept {
    const Optional<Vec3f> m = wi.z > 0 ? facet_between(wo, wi, 1) : std::nullopt;
    return m ? eval_at(wo, wi, *m) : BsdfValue();
  }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool, double u_lobe, Point2f u) const noexcept {
    const auto value = [&](const Vec3f& wi, const Vec3f& m) noexcept { return eval_at(wo, wi, m); };
    return sample_mirror_or_body(distribution, specular_probability((*transmittance_)(wo.z)), wo, u_lobe, u, value);
  }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    const float entering = (*transmittance_)(wo.z);
    return specular_reflectance * (1 - entering) + body_ * (entering * transmittance_->mean());
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    body_ = body_reflectance(diffuse_reflectance, transmittance_->internal_reflectance(), nonlinear, ior);
    specular_ = specular_reflectance.mean();
    diffuse_ = body_.mean() * transmittance_->mean();
  }

 private:
  [[nodiscard]] BsdfValue eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m) const noexcept {
    const float entering = (*transmittance_)(wo.z), specular = specular_probability(entering);
    // The cosine of half the angle between them, the same from both: where total reflection begins, Fresnel's
    // reflectance is so steep that the rounding of wo·m and wi·m would tell.
    const float reflectance = fresnel_dielectric(std::min(1.0F, 0.5F * length(wo + wi)), ior).reflectance;
    const FacetLobe mirror = mirrored(distribution, wo, wi, m);
    const float cosine = cosine_hemisphere_pdf(wi.z);
    return {specular_reflectance * (reflectance * mirror.f) + body_ * (cosine * entering * (*transmittance_)(wi.z)),
            specular * mirror.pdf + (1 - specular) * cosine};
  }
  /// The probability of sampling the specular lobe, given the interface's transmittance.
  [[nodiscard]] float specular_probability(float entering) const noexcept {
    const float mirror = specular_ * (1 - entering), body = diffuse_ * entering;
    return mirror > 0 ? mirror / (mirror + body) : 0.0F;
  }

  Spectrum body_;                            // f·π of the body without the interface's transmittances
  float specular_ = 0, diffuse_ = 0;         // how much each scatters of what the interface gives it
  const RoughTransmittance* transmittance_;  // of the scene's tables
};

}  // namespace equaltime
