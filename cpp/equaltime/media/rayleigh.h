// The phase function of Rayleigh (1871), 3/(16π)·(1 + cos²θ), for particles much smaller than the light's waves.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct RayleighDescription {
  friend bool operator==(const RayleighDescription&, const RayleighDescription&) = default;
};

struct RayleighPhase {
  using Description = RayleighDescription;
  static constexpr const char* name = "rayleigh";
  static constexpr bool Effects::*needs = &Effects::phase_blends;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = false;
  Spectrum single_albedo{1, 1, 1};

  explicit RayleighPhase(const Description& = {}) noexcept {}
  [[nodiscard]] static constexpr std::tuple<> fields() noexcept { return {}; }

  [[nodiscard]] static BsdfValue<float> eval(const Vec3f&, const Vec3f& wi, bool) noexcept {
    const float pdf = 0.75F * kUniformSpherePdf * (1 + wi.z * wi.z);
    return {Spectrum(pdf), pdf};
  }
  /// The cosine is the root of c³ + 3c = 2z, of which there is one, by Cardano.
  [[nodiscard]] static Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double, Point2f u) noexcept {
    const double z = 4 * static_cast<double>(u.x) - 2;
    const double root = elementary::cbrt(z + std::sqrt(z * z + 1));
    const double cosine = std::clamp(root - 1 / root, -1.0, 1.0);
    const auto sine = static_cast<float>(std::sqrt((1 - cosine) * (1 + cosine)));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
    const Vec3f wi{sine * cos_phi, sine * sin_phi, static_cast<float>(cosine)};
    return BsdfSample<float>{wi, Spectrum(1), eval(wo, wi, front).pdf};
  }
  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }
};

}  // namespace equaltime
