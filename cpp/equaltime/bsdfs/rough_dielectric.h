// Rough dielectric: microfacets that reflect and refract, one of the two at random by the Fresnel reflectance of a
// normal that is drawn among the visible ones.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/bsdf_types.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fresnel.h"

namespace equaltime {

struct RoughDielectricDescription {
  MicrofacetModel model = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1;
  DielectricDescription dielectric;
};

struct RoughDielectric {
  static constexpr const char* name = "roughdielectric";
  static constexpr bool Effects::*needs = &Effects::rough_dielectrics;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  Microfacet distribution;
  float ior;  // interior over exterior
  Spectrum specular_reflectance, specular_transmittance;

  explicit RoughDielectric(const RoughDielectricDescription& d) noexcept;
  void set(BsdfParameter parameter, const Spectrum& value) noexcept {
    if (parameter == BsdfParameter::specular_reflectance) specular_reflectance = value;
    if (parameter == BsdfParameter::specular_transmittance) specular_transmittance = value;
    distribution.set(parameter, value.luminance());
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
