// Smooth conductor: a mirror whose colour is the Fresnel reflectance of a complex index.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/bsdf_types.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/sampling/sampler.h"

namespace equaltime {

struct ConductorDescription {
  Vec3d eta, k, specular_reflectance;
};

struct Conductor {
  static constexpr const char* name = "conductor";
  static constexpr bool Effects::*needs = &Effects::specular;
  static constexpr bool is_delta = true;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Spectrum eta, k, specular_reflectance;

  explicit Conductor(const ConductorDescription& d) noexcept;
  void set(BsdfParameter parameter, const Spectrum& value) noexcept {
    if (parameter == BsdfParameter::eta) eta = value;
    if (parameter == BsdfParameter::k) k = value;
    if (parameter == BsdfParameter::specular_reflectance) specular_reflectance = value;
  }

  [[nodiscard]] static BsdfValue eval(const Vec3f&, const Vec3f&, bool) noexcept { return {}; }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool front, double, Point2f) const noexcept {
    return BsdfSample{{-wo.x, -wo.y, wo.z}, albedo(wo, front), 0, true};
  }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    return specular_reflectance * fresnel_conductor(wo.z, eta, k);
  }
};

}  // namespace equaltime
