// The phase function of Henyey and Greenstein (1941): where a particle scatters light to.
#pragma once

#include <algorithm>
#include <cmath>
#include <tuple>

#include "equaltime/base/effects.h"
#include "equaltime/base/fields.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct HenyeyGreensteinDescription {
  double g = 0;  // mean cosine between the directions before and after, in (-1, 1)

  friend bool operator==(const HenyeyGreensteinDescription&, const HenyeyGreensteinDescription&) = default;
};

struct HenyeyGreenstein {
  using Description = HenyeyGreensteinDescription;
  static constexpr const char* name = "hg";
  static constexpr bool Effects::*needs = &Effects::media;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = false;
  float g;
  Spectrum single_albedo{1, 1, 1};  // of the medium, for roulette

  explicit HenyeyGreenstein(const Description& d = {}) noexcept : g(static_cast<float>(d.g)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"g", &Description::g, Range{-1, 1, true}}};
  }

  /// Value and density are one: all that reaches the particle is scattered.
  [[nodiscard]] BsdfValue<float> eval(const Vec3f&, const Vec3f& wi, bool) const noexcept {
    // 1 + g² - 2g·cosθ without its cancellation where the lobe is sharp; light that goes straight on has z = -1.
    const float side = g < 0 ? wi.z : -wi.z;
    const float to_peak = side > 0 ? (wi.x * wi.x + wi.y * wi.y) / (1 + side) : 1 - side;
    const float narrow = 1 - std::abs(g);
    const float d = narrow * narrow + 2 * std::abs(g) * to_peak;
    const float pdf = kUniformSpherePdf * (1 - g) * (1 + g) / (d * std::sqrt(d));
    return {Spectrum(pdf), pdf};
  }

  [[nodiscard]] Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double, Point2f u) const noexcept {
    // The distribution of the cosine, inverted, in a form that does not divide by g.
    const double h = static_cast<double>(g), s = 1 - 2 * static_cast<double>(u.x), q = 1 + h * s;
    const double numerator = s + h * (0.5 * (s * s + 3) + h * (s + 0.5 * h * (s * s - 1)));
    const double cosine = std::clamp(numerator / (q * q), -1.0, 1.0);
    const auto sine = static_cast<float>(std::sqrt((1 - cosine) * (1 + cosine)));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
    const Vec3f wi{sine * cos_phi, sine * sin_phi, static_cast<float>(-cosine)};
    return BsdfSample<float>{wi, Spectrum(1), eval(wo, wi, front).pdf};
  }

  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }
};

}  // namespace equaltime
