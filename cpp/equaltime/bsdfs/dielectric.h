// Smooth dielectric: reflects and refracts, one of the two at random by the Fresnel reflectance.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct DielectricDescription {
  double ior = 1.5;  // interior over exterior
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

struct Dielectric {
  using Description = DielectricDescription;
  static constexpr const char* name = "dielectric";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  float ior;  // interior over exterior
  Spectrum specular_reflectance, specular_transmittance;

  explicit Dielectric(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &DielectricDescription::ior, kIor},
                      Field{"specular_reflectance", &DielectricDescription::specular_reflectance, kShare},
                      Field{"specular_transmittance", &DielectricDescription::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("specular_reflectance", &Dielectric::specular_reflectance),
                      color_slot("specular_transmittance", &Dielectric::specular_transmittance)};
  }

  [[nodiscard]] static BsdfValue eval(const Vec3f&, const Vec3f&, bool) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool front, double u_lobe, Point2f) const noexcept {
    const float eta = front ? ior : 1 / ior;
    const auto [reflectance, cos_transmitted] = fresnel_dielectric(wo.z, eta);
    if (u_lobe < reflectance) return BsdfSample{{-wo.x, -wo.y, wo.z}, specular_reflectance, 0, true};
    const float inv = 1 / eta;
    // Radiance is carried per solid angle, which refraction narrows by eta².
    const float compression = inv * inv;
    return BsdfSample{
        {-wo.x * inv, -wo.y * inv, -cos_transmitted}, specular_transmittance * compression, 0, true, compression};
  }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool front) const noexcept {
    const float reflectance = fresnel_dielectric(wo.z, front ? ior : 1 / ior).reflectance;
    return specular_reflectance * reflectance + specular_transmittance * (1 - reflectance);
  }
};

}  // namespace equaltime
