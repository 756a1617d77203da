// Tables of models, which are integrated at load. They stand in the scene, so that a model has only its parameters and
// where its table is, and models with the same parameters share one.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <map>

#include "equaltime/bsdfs/microfacet.h"

namespace equaltime {

/// How much light microfacets of a dielectric let through, by the cosine of one direction, all others integrated.
class RoughTransmittance {
 public:
  /// Integrates at load. Shadowed and masked light is lost, as by all models of single scattering here.
  RoughTransmittance(const Microfacet<float>& distribution, float ior);

  /// From outside; linear between knots at equal steps of the cosine, of which Mitsuba has as many.
  template <class Real>
  [[nodiscard]] Real operator()(Real cosine) const noexcept {
    return for_each_lane<Real>([this](float lane) noexcept { return at(lane); }, cosine);
  }
  /// The reflectance of diffuse light from within, by Mitsuba's rule: the mean over the knots, not over the interval,
  /// which is a 64th too little, and seen in pictures as a percent or two.
  [[nodiscard]] float internal_reflectance() const noexcept { return internal_reflectance_; }
  /// The transmittance of diffuse light from outside.
  [[nodiscard]] float mean() const noexcept { return mean_; }

 private:
  [[nodiscard]] float at(float cosine) const noexcept {
    const float x = std::max(0.0F, std::min(cosine, 1.0F)) * (kKnots - 1);
    const auto i = std::min(static_cast<std::size_t>(x), std::size_t{kKnots - 2});
    return std::lerp(from_outside_[i], from_outside_[i + 1], x - static_cast<float>(i));
  }

  static constexpr int kKnots = 64;
  std::array<float, kKnots> from_outside_;
  float internal_reflectance_, mean_;
};

/// The tables of a scene. References to them stay good when the whole is moved.
class BsdfTables {
 public:
  /// Returns the transmittance of isotropic microfacets; ior: interior over exterior. The first call for these
  /// parameters integrates it.
  [[nodiscard]] const RoughTransmittance& rough_transmittance(MicrofacetModel model, float alpha, float ior);
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return rough_transmittances_.size() * sizeof(RoughTransmittance);
  }

 private:
  struct Key {
    MicrofacetModel model;
    float alpha, ior;
    [[nodiscard]] auto operator<=>(const Key&) const noexcept = default;
  };
  std::map<Key, RoughTransmittance> rough_transmittances_;
};

}  // namespace equaltime
