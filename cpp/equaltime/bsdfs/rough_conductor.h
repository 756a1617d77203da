// Rough conductor: microfacet reflection with the Fresnel reflectance of a complex index (Walter et al. 2007, eq. 20).
// f·cosθi = F·D·G / (4 cosθo), G the product of both directions' Smith terms.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct RoughConductorDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1;
  Vec3d eta, k, specular_reflectance;
};

struct RoughConductor {
  using Description = RoughConductorDescription;
  static constexpr const char* name = "roughconductor";
  static constexpr bool Effects::*needs = &Effects::rough_conductors;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Microfacet distribution;
  Spectrum eta, k, specular_reflectance;

  explicit RoughConductor(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        eta(spectrum(d.eta)),
        k(spectrum(d.k)),
        specular_reflectance(spectrum(d.specular_reflectance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &RoughConductorDescription::distribution},
                      Field{"alpha_u", &RoughConductorDescription::alpha_u, kRoughness},
                      Field{"alpha_v", &RoughConductorDescription::alpha_v, kRoughness},
                      Field{"eta", &RoughConductorDescription::eta, kCoefficient},
                      Field{"k", &RoughConductorDescription::k, kCoefficient},
                      Field{"specular_reflectance", &RoughConductorDescription::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("eta", &RoughConductor::eta), color_slot("k", &RoughConductor::k),
                                     color_slot("specular_reflectance", &RoughConductor::specular_reflectance)},
                          textured_roughness());
  }

  [[nodiscard]] BsdfValue eval(const Vec3f& wo, const Vec3f& wi, bool) const noexcept {
    const Vec3f sum = wo + wi;
    if (!(wi.z > 0) || !(length_squared(sum) > 0)) return {};
    return eval_at(wo, wi, normalize(sum));
  }

  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool, double, Point2f u) const noexcept {
    const Vec3f m = distribution.sample(wo, u);
    const Vec3f wi = m * (2 * dot(wo, m)) - wo;
    if (!(wi.z > 0)) return std::nullopt;
    const BsdfValue value = eval_at(wo, wi, m);
    if (!(value.pdf > 0)) return std::nullopt;
    return BsdfSample{wi, value.f * (1 / value.pdf), value.pdf};
  }
  /// That of the smooth conductor: the rough one reflects a little less, which shadowing takes.
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    return specular_reflectance * fresnel_conductor(wo.z, eta, k);
  }

 private:
  [[nodiscard]] BsdfValue eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m) const noexcept {
    const float d = distribution.D(m);
    const float g = distribution.G1(wo) * distribution.G1(wi);
    const Spectrum fresnel = fresnel_conductor(std::min(1.0F, dot(wo, m)), eta, k);
    return {specular_reflectance * fresnel * (d * g / (4 * wo.z)), distribution.reflected_pdf(wo, d)};
  }
};

}  // namespace equaltime
