// Rough plastic: microfacets of a dielectric over a diffuse body. Mitsuba's model: what enters the body and leaves it
// is the share of light that one refraction by microfacets lets through.
#pragma once

#include "equaltime/bsdfs/microfacet_plastic.h"
#include "equaltime/bsdfs/plastic.h"
#include "equaltime/bsdfs/tables.h"
#include "equaltime/bsdfs/texture_slots.h"

namespace equaltime {

struct RoughPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
  bool nonlinear = false;  // see PlasticDescription
};

template <class Real>
struct RoughPlastic {
  using Description = RoughPlasticDescription;
  static constexpr const char* name = "roughplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  bool nonlinear;
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  RoughPlastic(const Description& d, BsdfTables& tables)
      : distribution(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.alpha)),
        ior(static_cast<float>(d.ior)),
        nonlinear(d.nonlinear),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        transmittance_(
            &tables.rough_transmittance(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.ior))) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &Description::distribution},
                      Field{"alpha", &Description::alpha, kRoughness},
                      Field{"ior", &Description::ior, kIor},
                      Field{"diffuse_reflectance", &Description::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare},
                      Field{"nonlinear", &Description::nonlinear}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("diffuse_reflectance", &RoughPlastic::diffuse_reflectance),
                      color_slot("specular_reflectance", &RoughPlastic::specular_reflectance)};
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    return eval_plastic(*this, wo, wi);
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    return sample_plastic(*this, wo, u_lobe, u);
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept { return plastic_albedo(*this, wo); }
  [[nodiscard]] InterfaceShares<Real> shares(Real cosine) const noexcept {
    const Real entering = (*transmittance_)(cosine);
    return {1 - entering, entering};
  }
  [[nodiscard]] const Rgb<Real>& body() const noexcept { return body_; }
  [[nodiscard]] Real mean_entering() const noexcept { return transmittance_->mean(); }
  [[nodiscard]] const LobeWeights<Real>& weights() const noexcept { return weights_; }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    const Real internal = transmittance_->internal_reflectance();
    body_ = body_reflectance(diffuse_reflectance, internal, nonlinear, ior);
    weights_ = plastic_weights(*this);
  }

 private:
  Rgb<Real> body_;
  LobeWeights<Real> weights_;
  const RoughTransmittance* transmittance_;  // of the scene's tables; all lanes share one
};

}  // namespace equaltime
