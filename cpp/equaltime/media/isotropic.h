// The isotropic phase function: light is scattered equally in all directions.
#pragma once

#include <cmath>
#include <tuple>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct IsotropicDescription {
  friend bool operator==(const IsotropicDescription&, const IsotropicDescription&) = default;
};

struct IsotropicPhase {
  using Description = IsotropicDescription;
  static constexpr const char* name = "isotropic";
  static constexpr bool Effects::*needs = &Effects::media;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = false;
  Spectrum single_albedo{1, 1, 1};

  explicit IsotropicPhase(const Description& = {}) noexcept {}
  [[nodiscard]] static constexpr std::tuple<> fields() noexcept { return {}; }

  [[nodiscard]] static BsdfValue<float> eval(const Vec3f&, const Vec3f&, bool) noexcept {
    return {Spectrum(kUniformSpherePdf), kUniformSpherePdf};
  }
  [[nodiscard]] static Optional<BsdfSample<float>> sample(const Vec3f&, bool, double, Point2f u) noexcept {
    const double z = 2 * static_cast<double>(u.x) - 1;
    const auto sine = static_cast<float>(std::sqrt((1 - z) * (1 + z)));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
    return BsdfSample<float>{{sine * cos_phi, sine * sin_phi, static_cast<float>(z)}, Spectrum(1), kUniformSpherePdf};
  }
  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }
};

}  // namespace equaltime
