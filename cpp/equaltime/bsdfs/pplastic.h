// Plastic without light that is reflected back into its body: microfacets of a dielectric over a diffuse body, which
// light enters and leaves by one refraction each. Mitsuba's model of polarised plastic, for light that is not.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/lobe_weights.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct PPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
};

template <class Real>
struct PPlastic {
  using Description = PPlasticDescription;
  static constexpr const char* name = "pplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  explicit PPlastic(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        ior(static_cast<float>(d.ior)),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        mean_entering_(1 - fresnel_diffuse(ior)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &PPlasticDescription::distribution},
                      Field{"alpha_u", &PPlasticDescription::alpha_u, kRoughness},
                      Field{"alpha_v", &PPlasticDescription::alpha_v, kRoughness},
                      Field{"ior", &PPlasticDescription::ior, kIor},
                      Field{"diffuse_reflectance", &PPlasticDescription::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &PPlasticDescription::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("diffuse_reflectance", &PPlastic::diffuse_reflectance),
                                     color_slot("specular_reflectance", &PPlastic::specular_reflectance)},
                          textured_roughness());
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    const Optional<Vec3<Real>> m = facet_between(wo, wi, Real(1));
    return where(wi.z > 0 && m.has_value(), [&] { return eval_at(wo, wi, *m); });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    const auto value = [&](const Vec3<Real>& wi, const Vec3<Real>& m) noexcept { return eval_at(wo, wi, m); };
    return sample_mirror_or_body(distribution, specular_probability(fresnel(wo.z)), wo, u_lobe, u, value);
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const Real reflectance = fresnel(wo.z);
    return specular_reflectance * reflectance + diffuse_reflectance * ((1 - reflectance) * mean_entering_);
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept { weights_ = {specular_reflectance.mean(), diffuse_reflectance.mean() * mean_entering_}; }

 private:
  [[nodiscard]] BsdfValue<Real> eval_at(const Vec3<Real>& wo, const Vec3<Real>& wi,
                                        const Vec3<Real>& m) const noexcept {
    const Real reflected = fresnel(wo.z), specular = specular_probability(reflected);
    // The cosine of half the angle between them, the same from both; see RoughPlastic.
    const Real reflectance = fresnel(min(Real(1), 0.5F * length(wo + wi)));
    const FacetLobe<Real> mirror = mirrored(distribution, wo, wi, m);
    const Real cosine = cosine_hemisphere_pdf(wi.z);
    return {specular_reflectance * (reflectance * mirror.f) +
                diffuse_reflectance * (cosine * (1 - reflected) * (1 - fresnel(wi.z))),
            specular * mirror.pdf + (1 - specular) * cosine};
  }
  [[nodiscard]] Real fresnel(Real cosine) const noexcept { return fresnel_dielectric(cosine, ior).reflectance; }
  [[nodiscard]] Real specular_probability(Real reflectance) const noexcept {
    return weights_.specular_probability(reflectance, 1 - reflectance);
  }

  Real mean_entering_;  // the mean transmittance of the interface from outside
  LobeWeights<Real> weights_;
};

}  // namespace equaltime
