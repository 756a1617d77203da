// Plastic without light that is reflected back into its body: microfacets of a dielectric over a diffuse body, which
// light enters and leaves by one refraction each. Mitsuba's model of polarised plastic, for light that is not.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct PPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
};

struct PPlastic {
  using Description = PPlasticDescription;
  static constexpr const char* name = "pplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet distribution;
  float ior;  // interior over exterior
  Spectrum diffuse_reflectance, specular_reflectance;

  explicit PPlastic(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        ior(static_cast<float>(d.ior)),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        entering_(1 - fresnel_diffuse(ior)) {
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

  [[nodiscard]] BsdfValue eval(const Vec3f& wo, const Vec3f& wi, bool) const noexcept {
    const Optional<Vec3f> m = wi.z > 0 ? facet_between(wo, wi, 1) : std::nullopt;
    return m ? eval_at(wo, wi, *m) : BsdfValue();
  }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool, double u_lobe, Point2f u) const noexcept {
    const auto value = [&](const Vec3f& wi, const Vec3f& m) noexcept { return eval_at(wo, wi, m); };
    return sample_mirror_or_body(distribution, specular_probability(interface(wo.z)), wo, u_lobe, u, value);
  }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    const float reflectance = interface(wo.z);
    return specular_reflectance * reflectance + diffuse_reflectance * ((1 - reflectance) * entering_);
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    specular_ = specular_reflectance.mean();
    diffuse_ = diffuse_reflectance.mean() * entering_;
  }

 private:
  [[nodiscard]] BsdfValue eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m) const noexcept {
    const float reflected = interface(wo.z), specular = specular_probability(reflected);
    // The cosine of half the angle between them, the same from both; see RoughPlastic.
    const float reflectance = interface(std::min(1.0F, 0.5F * length(wo + wi)));
    const FacetLobe mirror = mirrored(distribution, wo, wi, m);
    const float cosine = cosine_hemisphere_pdf(wi.z);
    return {specular_reflectance * (reflectance * mirror.f) +
                diffuse_reflectance * (cosine * (1 - reflected) * (1 - interface(wi.z))),
            specular * mirror.pdf + (1 - specular) * cosine};
  }
  [[nodiscard]] float interface(float cosine) const noexcept { return fresnel_dielectric(cosine, ior).reflectance; }
  /// The probability of sampling the specular lobe, given the interface's reflectance.
  [[nodiscard]] float specular_probability(float reflectance) const noexcept {
    const float mirror = specular_ * reflectance, body = diffuse_ * (1 - reflectance);
    return mirror > 0 ? mirror / (mirror + body) : 0.0F;
  }

  float entering_;                    // the mean transmittance of the interface from outside
  float specular_ = 0, diffuse_ = 0;  // how much each scatters of what the interface gives it
};

}  // namespace equaltime
