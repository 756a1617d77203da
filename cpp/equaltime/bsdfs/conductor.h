// Smooth conductor: a mirror whose colour is the Fresnel reflectance of a complex index.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct ConductorDescription {
  Vec3d eta, k, specular_reflectance;
};

template <class Real>
struct Conductor {
  using Description = ConductorDescription;
  static constexpr const char* name = "conductor";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Rgb<Real> eta, k, specular_reflectance;

  explicit Conductor(const Description& d) noexcept
      : eta(spectrum(d.eta)), k(spectrum(d.k)), specular_reflectance(spectrum(d.specular_reflectance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"eta", &Description::eta, kCoefficient}, Field{"k", &Description::k, kCoefficient},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("eta", &Conductor::eta), color_slot("k", &Conductor::k),
                      color_slot("specular_reflectance", &Conductor::specular_reflectance)};
  }

  [[nodiscard]] static BsdfValue<Real> eval(const Vec3<Real>&, const Vec3<Real>&, Mask<Real>) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real> front, Double<Real>,
                                                  Point2<Real>) const noexcept {
    return BsdfSample<Real>{{-wo.x, -wo.y, wo.z}, albedo(wo, front), 0, true};
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    return specular_reflectance * fresnel_conductor(wo.z, eta, k);
  }
};

}  // namespace equaltime
