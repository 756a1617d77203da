// Rough conductor: microfacet reflection with the Fresnel reflectance of a complex index (Walter et al. 2007, eq. 20).
// f·cosθi = F·D·G / (4 cosθo), G the product of both directions' Smith terms.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct RoughConductorDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1;
  Vec3d eta, k, specular_reflectance;
};

template <class Real>
struct RoughConductor {
  using Description = RoughConductorDescription;
  static constexpr const char* name = "roughconductor";
  static constexpr bool Effects::*needs = &Effects::rough_conductors;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Microfacet<Real> distribution;
  Rgb<Real> eta, k, specular_reflectance;

  explicit RoughConductor(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        eta(spectrum(d.eta)),
        k(spectrum(d.k)),
        specular_reflectance(spectrum(d.specular_reflectance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &Description::distribution},
                      Field{"alpha_u", &Description::alpha_u, kRoughness},
                      Field{"alpha_v", &Description::alpha_v, kRoughness},
                      Field{"eta", &Description::eta, kCoefficient},
                      Field{"k", &Description::k, kCoefficient},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("eta", &RoughConductor::eta), color_slot("k", &RoughConductor::k),
                                     color_slot("specular_reflectance", &RoughConductor::specular_reflectance)},
                          textured_roughness());
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    const Vec3<Real> sum = wo + wi;
    return where(wi.z > 0 && length_squared(sum) > 0, [&] { return eval_at(wo, wi, normalize(sum)); });
  }

  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real>,
                                                  Point2<Real> u) const noexcept {
    const Vec3<Real> m = distribution.sample(wo, u);
    const Vec3<Real> wi = m * (2 * dot(wo, m)) - wo;
    const Mask<Real> upper = wi.z > 0;
    if (none(upper)) return std::nullopt;
    return sample_of(wi, eval_at(wo, wi, m), upper);
  }
  /// That of the smooth conductor: the rough one reflects a little less, which shadowing takes.
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    return specular_reflectance * fresnel_conductor(wo.z, eta, k);
  }

 private:
  [[nodiscard]] BsdfValue<Real> eval_at(const Vec3<Real>& wo, const Vec3<Real>& wi,
                                        const Vec3<Real>& m) const noexcept {
    const Real d = distribution.D(m);
    const Real g = distribution.G1(wo) * distribution.G1(wi);
    const Rgb<Real> fresnel = fresnel_conductor(min(Real(1), dot(wo, m)), eta, k);
    return {specular_reflectance * fresnel * (d * g / (4 * wo.z)), distribution.reflected_pdf(wo, d)};
  }
};

}  // namespace equaltime
