// A sum of phase functions, each with its weight.
#pragma once

#include <array>
#include <cstdint>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/base/type_list.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

/// `Lobes` is the list of phase functions that may be in it.
template <class Lobes>
struct BlendedPhase {
  static constexpr const char* name = "blendphase";
  static constexpr bool Effects::*needs = &Effects::phase_blends;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = true;
  static constexpr std::size_t kMostLobes = 8;
  struct Lobe {
    float weight = 0;  // of all that is scattered; the weights of a blend add up to 1
    typename Lobes::Variant phase;
  };
  std::array<Lobe, kMostLobes> lobes{};
  std::uint32_t count = 0;
  Spectrum single_albedo{1, 1, 1};

  /// Of all lobes, whichever drew the direction: value and density are one.
  [[nodiscard]] BsdfValue<float> eval(const Vec3f& wo, const Vec3f& wi, bool front) const noexcept {
    float pdf = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto pdf_of = [&](const auto& phase) noexcept { return phase.eval(wo, wi, front).pdf; };
      pdf += lobes[i].weight * visit<kAllEffects>(lobes[i].phase, pdf_of);
    }
    return {Spectrum(pdf), pdf};
  }

  [[nodiscard]] Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double u_lobe,
                                                   Point2f u) const noexcept {
    std::uint32_t picked = 0;
    for (; picked + 1 < count && u_lobe >= lobes[picked].weight; ++picked) u_lobe -= lobes[picked].weight;
    const auto draw = [&](const auto& phase) noexcept { return phase.sample(wo, front, 0, u)->wi; };
    const Vec3f wi = visit<kAllEffects>(lobes[picked].phase, draw);
    return BsdfSample<float>{wi, Spectrum(1), eval(wo, wi, front).pdf};
  }

  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }
};

}  // namespace equaltime
