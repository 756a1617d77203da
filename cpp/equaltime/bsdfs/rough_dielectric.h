// Rough dielectric: microfacets that reflect and refract, one of the two at random by the Fresnel reflectance of a
// normal that is drawn among the visible ones.
#pragma once

#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/dielectric.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct RoughDielectricDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

template <class Real>
struct RoughDielectric {
  using Description = RoughDielectricDescription;
  static constexpr const char* name = "roughdielectric";
  static constexpr bool Effects::*needs = &Effects::rough_dielectrics;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  Rgb<Real> specular_reflectance, specular_transmittance;

  explicit RoughDielectric(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  /// With an index of 1 nothing is refracted: light passes straight on, however rough the facets are.
  [[nodiscard]] static std::optional<Dielectric<Real>> simpler(const Description& d) noexcept {
    if (static_cast<float>(d.ior) != 1) return std::nullopt;
    return Dielectric<Real>(DielectricDescription{d.ior, d.specular_reflectance, d.specular_transmittance});
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &Description::distribution},
                      Field{"alpha_u", &Description::alpha_u, kRoughness},
                      Field{"alpha_v", &Description::alpha_v, kRoughness},
                      Field{"ior", &Description::ior, kIor},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare},
                      Field{"specular_transmittance", &Description::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("specular_reflectance", &RoughDielectric::specular_reflectance),
                                     color_slot("specular_transmittance", &RoughDielectric::specular_transmittance)},
                          textured_roughness());
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real> front) const noexcept {
    const Real eta = relative_ior(ior, front);
    const Optional<Vec3<Real>> m = half_vector(wo, wi, eta);
    return where(m.has_value(), [&] {
      return eval_at(wo, wi, *m, eta, fresnel_dielectric(min(Real(1), dot(wo, *m)), eta).reflectance);
    });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real> front, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    const Real eta = relative_ior(ior, front);
    const Vec3<Real> m = distribution.sample(wo, u);
    const Real c = min(Real(1), dot(wo, m));
    const DielectricFresnel<Real> fresnel = fresnel_dielectric(c, eta);
    const Mask<Real> reflects = u_lobe < Double<Real>(fresnel.reflectance);
    const Vec3<Real> wi = where(
        reflects, [&] { return m * (2 * c) - wo; },
        [&] { return m * (c / eta - fresnel.cos_transmitted) - wo * (1 / eta); });
    const Mask<Real> leaves = (reflects && wi.z > 0) || (!reflects && wi.z < 0);
    if (none(leaves)) return std::nullopt;
    const Real eta_scale = where(
        reflects, [] { return Real(1); }, [&] { return 1 / square(eta); });
    return sample_of(wi, eval_at(wo, wi, m, eta, fresnel.reflectance), leaves, eta_scale);
  }
  /// Approximates the albedo by the smooth dielectric's. Transmittance is at least 0.25, because tilted facets refract
  /// even where a smooth surface reflects everything.
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real> front) const noexcept {
    const Real reflectance = fresnel_dielectric(wo.z, relative_ior(ior, front)).reflectance;
    return specular_reflectance * reflectance + specular_transmittance * max(1 - reflectance, Real(0.25F));
  }

 private:
  [[nodiscard]] BsdfValue<Real> eval_at(const Vec3<Real>& wo, const Vec3<Real>& wi, const Vec3<Real>& m, Real eta,
                                        Real reflectance) const noexcept {
    const Mask<Real> reflects = wi.z > 0;
    const auto [f, pdf] = where(
        reflects, [&] { return reflected(distribution, wo, wi, m); },
        [&] { return refracted(distribution, wo, wi, m, eta); });
    const Real share = select(reflects, reflectance, 1 - reflectance);
    return {select(reflects, specular_reflectance, specular_transmittance) * (share * f), share * pdf};
  }
};

}  // namespace equaltime
