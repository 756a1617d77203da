// Rough plastic: microfacets of a dielectric over a diffuse body. Mitsuba's model: what enters the body and leaves it
// is the share of light that one refraction by microfacets lets through.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/lobe_weights.h"
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

template <class Real>
struct RoughPlastic {
  using Description = RoughPlasticDescription;
  static constexpr const char* name = "roughplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  bool nonlinear;
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  RoughPlastic(const Description& d, BsdfTables& tables)
      : distribution(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.alpha)),
        ior(static_cast<float>(d.ior)),
        nonlinear(d.nonlinear),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        transmittance_(
            &tables.rough_transmittance(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.ior))) {
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

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    const Optional<Vec3<Real>> m = facet_between(wo, wi, Real(1));
    return where(wi.z > 0 && m.has_value(), [&] { return eval_at(wo, wi, *m); });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    const auto value = [&](const Vec3<Real>& wi, const Vec3<Real>& m) noexcept { return eval_at(wo, wi, m); };
    return sample_mirror_or_body(distribution, specular_probability((*transmittance_)(wo.z)), wo, u_lobe, u, value);
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const Real entering = (*transmittance_)(wo.z);
    return specular_reflectance * (1 - entering) + body_ * (entering * transmittance_->mean());
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    body_ = body_reflectance(diffuse_reflectance, Real(transmittance_->internal_reflectance()), nonlinear, ior);
    weights_ = {specular_reflectance.mean(), body_.mean() * transmittance_->mean()};
  }

 private:
  [[nodiscard]] BsdfValue<Real> eval_at(const Vec3<Real>& wo, const Vec3<Real>& wi,
                                        const Vec3<Real>& m) const noexcept {
    const Real entering = (*transmittance_)(wo.z), specular = specular_probability(entering);
    // The cosine of half the angle between them, the same from both: where total reflection begins, Fresnel's
    // reflectance is so steep that the rounding of wo·m and wi·m would tell.
    const Real reflectance = fresnel_dielectric(min(Real(1), 0.5F * length(wo + wi)), ior).reflectance;
    const FacetLobe<Real> mirror = mirrored(distribution, wo, wi, m);
    const Real cosine = cosine_hemisphere_pdf(wi.z);
    return {specular_reflectance * (reflectance * mirror.f) + body_ * (cosine * entering * (*transmittance_)(wi.z)),
            specular * mirror.pdf + (1 - specular) * cosine};
  }
  [[nodiscard]] Real specular_probability(Real entering) const noexcept {
    return weights_.specular_probability(1 - entering, entering);
  }

  Rgb<Real> body_;  // f·π of the body without the interface's transmittances
  LobeWeights<Real> weights_;
  const RoughTransmittance* transmittance_;  // of the scene's tables; all lanes share one
};

}  // namespace equaltime
