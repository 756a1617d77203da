// Smooth dielectric: reflects and refracts, one of the two at random by the Fresnel reflectance.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct DielectricDescription {
  double ior = 1.5;  // interior over exterior
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

template <class Real>
struct Dielectric {
  using Description = DielectricDescription;
  static constexpr const char* name = "dielectric";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  Real ior;  // interior over exterior
  Rgb<Real> specular_reflectance, specular_transmittance;

  explicit Dielectric(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &Description::ior, kIor},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare},
                      Field{"specular_transmittance", &Description::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("specular_reflectance", &Dielectric::specular_reflectance),
                      color_slot("specular_transmittance", &Dielectric::specular_transmittance)};
  }

  [[nodiscard]] static BsdfValue<Real> eval(const Vec3<Real>&, const Vec3<Real>&, Mask<Real>) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real> front, Double<Real> u_lobe,
                                                  Point2<Real>) const noexcept {
    const Real eta = relative_ior(ior, front), inv = 1 / eta;
    const DielectricFresnel<Real> fresnel = fresnel_dielectric(wo.z, eta);
    const Real compression = inv * inv;  // radiance is carried per solid angle, which refraction narrows by eta²
    return where(
        u_lobe < Double<Real>(fresnel.reflectance),
        [&] {
          return BsdfSample<Real>{{-wo.x, -wo.y, wo.z}, specular_reflectance, 0, true};
        },
        [&] {
          const Vec3<Real> wi{-wo.x * inv, -wo.y * inv, -fresnel.cos_transmitted};
          return BsdfSample<Real>{wi, specular_transmittance * compression, 0, true, compression};
        });
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real> front) const noexcept {
    const Real reflectance = fresnel_dielectric(wo.z, relative_ior(ior, front)).reflectance;
    return specular_reflectance * reflectance + specular_transmittance * (1 - reflectance);
  }
};

}  // namespace equaltime
