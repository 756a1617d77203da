// Thin sheet of a dielectric: a mirror, or straight through, with all reflections between its two sides summed up.
// Both sides are alike: outside is on either.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct ThinDielectricDescription {
  double ior = 1.5;  // sheet over surroundings
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};

struct ThinDielectric {
  using Description = ThinDielectricDescription;
  static constexpr const char* name = "thindielectric";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  float ior;  // of the sheet over that of what is round it
  Spectrum specular_reflectance, specular_transmittance;

  explicit ThinDielectric(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        specular_transmittance(spectrum(d.specular_transmittance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &ThinDielectricDescription::ior, kIor},
                      Field{"specular_reflectance", &ThinDielectricDescription::specular_reflectance, kShare},
                      Field{"specular_transmittance", &ThinDielectricDescription::specular_transmittance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("specular_reflectance", &ThinDielectric::specular_reflectance),
                      color_slot("specular_transmittance", &ThinDielectric::specular_transmittance)};
  }

  [[nodiscard]] static BsdfValue eval(const Vec3f&, const Vec3f&, bool) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool, double u_lobe, Point2f) const noexcept {
    if (u_lobe < reflectance(wo)) return BsdfSample{{-wo.x, -wo.y, wo.z}, specular_reflectance, 0, true};
    return BsdfSample{-wo, specular_transmittance, 0, true};
  }
  /// What goes straight through, of the light of both ways.
  [[nodiscard]] Spectrum transmittance(const Vec3f& wo) const noexcept {
    return specular_transmittance * (1 - reflectance(wo));
  }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    const float r = reflectance(wo);
    return specular_reflectance * r + specular_transmittance * (1 - r);
  }

 private:
  /// R + T²R + T²R³ + … = 2R / (1 + R), with R of one interface and T = 1 - R.
  [[nodiscard]] float reflectance(const Vec3f& wo) const noexcept {
    const float r = fresnel_dielectric(wo.z, ior).reflectance;
    return 2 * r / (1 + r);
  }
};

}  // namespace equaltime
