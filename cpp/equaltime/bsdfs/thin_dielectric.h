// Thin sheet of a dielectric: a mirror, or straight through, with all reflections between its two sides summed up.
// Both sides are alike: outside is on either.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct ThinDielectricDescription {
  double ior = 1.5;  // sheet over surroundings
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

template <class Real>
struct ThinDielectric {
  using Description = ThinDielectricDescription;
  static constexpr const char* name = "thindielectric";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  Real ior;  // of the sheet over that of what is round it
  Rgb<Real> specular_reflectance, specular_transmittance;

  explicit ThinDielectric(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &Description::ior, kIor},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare},
                      Field{"specular_transmittance", &Description::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("specular_reflectance", &ThinDielectric::specular_reflectance),
                      color_slot("specular_transmittance", &ThinDielectric::specular_transmittance)};
  }

  [[nodiscard]] static BsdfValue<Real> eval(const Vec3<Real>&, const Vec3<Real>&, Mask<Real>) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real> u_lobe,
                                                  Point2<Real>) const noexcept {
    const Mask<Real> reflects = u_lobe < Double<Real>(reflectance(wo));
    const Vec3<Real> wi{-wo.x, -wo.y, select(reflects, wo.z, -wo.z)};
    return BsdfSample<Real>{wi, select(reflects, specular_reflectance, specular_transmittance), 0, true};
  }
  /// What goes straight through, of the light of both ways.
  [[nodiscard]] Rgb<Real> transmittance(const Vec3<Real>& wo) const noexcept {
    return specular_transmittance * (1 - reflectance(wo));
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const Real r = reflectance(wo);
    return specular_reflectance * r + specular_transmittance * (1 - r);
  }

 private:
  /// R + T²R + T²R³ + … = 2R / (1 + R), with R of one interface and T = 1 - R.
  [[nodiscard]] Real reflectance(const Vec3<Real>& wo) const noexcept {
    const Real r = fresnel_dielectric(wo.z, ior).reflectance;
    return 2 * r / (1 + r);
  }
};

}  // namespace equaltime
