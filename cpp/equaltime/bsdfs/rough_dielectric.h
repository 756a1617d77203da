// Rough dielectric: microfacets that reflect and refract, one of the two at random by the Fresnel reflectance of a
// normal that is drawn among the visible ones.
#pragma once

#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/dielectric.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct RoughDielectricDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

struct RoughDielectric {
  using Description = RoughDielectricDescription;
  static constexpr const char* name = "roughdielectric";
  static constexpr bool Effects::*needs = &Effects::rough_dielectrics;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  Microfacet distribution;
  float ior;  // interior over exterior
  Spectrum specular_reflectance, specular_transmittance;

  explicit RoughDielectric(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  /// Facets of no contrast bend nothing: light passes straight on, however rough they are.
  [[nodiscard]] static std::optional<Dielectric> simpler(const Description& d) noexcept {
    if (static_cast<float>(d.ior) != 1) return std::nullopt;
    return Dielectric(DielectricDescription{d.ior, d.specular_reflectance, d.specular_transmittance});
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &RoughDielectricDescription::distribution},
                      Field{"alpha_u", &RoughDielectricDescription::alpha_u, kRoughness},
                      Field{"alpha_v", &RoughDielectricDescription::alpha_v, kRoughness},
                      Field{"ior", &RoughDielectricDescription::ior, kIor},
                      Field{"specular_reflectance", &RoughDielectricDescription::specular_reflectance, kShare},
                      Field{"specular_transmittance", &RoughDielectricDescription::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("specular_reflectance", &RoughDielectric::specular_reflectance),
                                     color_slot("specular_transmittance", &RoughDielectric::specular_transmittance)},
                          textured_roughness());
  }

  [[nodiscard]] BsdfValue eval(const Vec3f& wo, const Vec3f& wi, bool front) const noexcept {
    const float eta = front ? ior : 1 / ior;
    const Optional<Vec3f> m = facet_between(wo, wi, eta);
    if (!m) return {};
    return eval_at(wo, wi, *m, eta, fresnel_dielectric(std::min(1.0F, dot(wo, *m)), eta).reflectance);
  }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool front, double u_lobe, Point2f u) const noexcept {
    const float eta = front ? ior : 1 / ior;
    const Vec3f m = distribution.sample(wo, u);
    const float c = std::min(1.0F, dot(wo, m));
    const auto [reflectance, cos_transmitted] = fresnel_dielectric(c, eta);
    const bool mirrors = u_lobe < reflectance;
    const Vec3f wi = mirrors ? m * (2 * c) - wo : m * (c / eta - cos_transmitted) - wo * (1 / eta);
    if (mirrors ? !(wi.z > 0) : !(wi.z < 0)) return std::nullopt;
    const BsdfValue value = eval_at(wo, wi, m, eta, reflectance);
    if (!(value.pdf > 0)) return std::nullopt;
    return BsdfSample{wi, value.f * (1 / value.pdf), value.pdf, false, mirrors ? 1.0F : 1 / square(eta)};
  }
  /// Nearly that of the smooth dielectric. Where that one reflects all, facets that lean still refract.
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool front) const noexcept {
    const float reflectance = fresnel_dielectric(wo.z, front ? ior : 1 / ior).reflectance;
    return specular_reflectance * reflectance + specular_transmittance * std::max(1 - reflectance, 0.25F);
  }

 private:
  [[nodiscard]] BsdfValue eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m, float eta,
                                  float reflectance) const noexcept {
    const bool mirrors = wi.z > 0;
    const auto [f, pdf] = mirrors ? mirrored(distribution, wo, wi, m) : refracted(distribution, wo, wi, m, eta);
    const float share = mirrors ? reflectance : 1 - reflectance;
    return {(mirrors ? specular_reflectance : specular_transmittance) * (share * f), share * pdf};
  }
};

}  // namespace equaltime
