// Phase functions that Henyey and Greenstein's alone is not: Rayleigh's (1871), 3/(16π)·(1 + cos²θ), which is that of
// what is much smaller than the light's waves, and sums of both kinds, each with its weight.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "equaltime/base/effects.h"
#include "equaltime/math/elementary.h"
#include "equaltime/media/henyey_greenstein.h"

namespace equaltime {

struct PhaseLobe {
  float weight = 0;  // of all that is scattered; those of a blend add up to 1
  float g = 0;
  bool rayleigh = false;  // instead of g's law
};

struct BlendedPhase {
  static constexpr const char* name = "blendphase";
  static constexpr bool Effects::*needs = &Effects::phase_blends;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  static constexpr std::size_t kMostLobes = 8;
  std::array<PhaseLobe, kMostLobes> lobes{};
  std::uint32_t count = 0;
  Spectrum single_albedo{1, 1, 1};  // of the medium

  /// Of all lobes, whichever drew the direction: value and density are one.
  [[nodiscard]] BsdfValue<float> eval(const Vec3f& wo, const Vec3f& wi, bool front) const noexcept {
    float pdf = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto& [weight, g, rayleigh] = lobes[i];
      pdf += weight * (rayleigh ? rayleigh_pdf(wi.z) : HenyeyGreenstein{g, {}}.eval(wo, wi, front).pdf);
    }
    return {Spectrum(pdf), pdf};
  }

  [[nodiscard]] Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double u_lobe,
                                                   Point2f u) const noexcept {
    std::uint32_t picked = 0;
    for (; picked + 1 < count && u_lobe >= lobes[picked].weight; ++picked) u_lobe -= lobes[picked].weight;
    const PhaseLobe& lobe = lobes[picked];
    const Vec3f wi = lobe.rayleigh ? rayleigh_direction(u) : HenyeyGreenstein{lobe.g, {}}.sample(wo, front, 0, u)->wi;
    return BsdfSample<float>{wi, Spectrum(1), eval(wo, wi, front).pdf};
  }

  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }

 private:
  [[nodiscard]] static float rayleigh_pdf(float cosine) noexcept {
    return 0.75F * kUniformSpherePdf * (1 + cosine * cosine);
  }
  /// The cosine is the root of c³ + 3c = 2z, of which there is one, by Cardano.
  [[nodiscard]] static Vec3f rayleigh_direction(Point2f u) noexcept {
    const double z = 4 * static_cast<double>(u.x) - 2;
    const double root = elementary::cbrt(z + std::sqrt(z * z + 1));
    const double cosine = std::clamp(root - 1 / root, -1.0, 1.0);
    const auto sine = static_cast<float>(std::sqrt((1 - cosine) * (1 + cosine)));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
    return {sine * cos_phi, sine * sin_phi, static_cast<float>(cosine)};
  }
};

}  // namespace equaltime
