// Rough plastic: microfacets of a dielectric over a diffuse body. Mitsuba's model: what enters the body and leaves it
// is the share of light that one refraction by microfacets lets through.
#pragma once

#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/microfacet_plastic.h"
#include "equaltime/bsdfs/plastic.h"
#include "equaltime/bsdfs/tables.h"

namespace equaltime {

struct RoughPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
  bool nonlinear = false;  // see PlasticDescription
};

template <class Real>
struct RoughPlastic : MicrofacetPlastic<Real, RoughPlastic<Real>> {
  using Description = RoughPlasticDescription;
  static constexpr const char* name = "roughplastic";
  bool nonlinear;

  RoughPlastic(const Description& d, BsdfTables& tables)
      : MicrofacetPlastic<Real, RoughPlastic>(d, d.alpha, d.alpha),
        nonlinear(d.nonlinear),
        transmittance_(
            &tables.rough_transmittance(d.distribution, static_cast<float>(d.alpha), static_cast<float>(d.ior))) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &RoughPlasticDescription::distribution},
                      Field{"alpha", &RoughPlasticDescription::alpha, kRoughness},
                      Field{"ior", &RoughPlasticDescription::ior, kIor},
                      Field{"diffuse_reflectance", &RoughPlasticDescription::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &RoughPlasticDescription::specular_reflectance, kShare},
                      Field{"nonlinear", &RoughPlasticDescription::nonlinear}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("diffuse_reflectance", &RoughPlastic::diffuse_reflectance),
                      color_slot("specular_reflectance", &RoughPlastic::specular_reflectance)};
  }

  [[nodiscard]] InterfaceShares<Real> shares(Real cosine) const noexcept {
    const Real entering = (*transmittance_)(cosine);
    return {1 - entering, entering};
  }
  [[nodiscard]] const Rgb<Real>& body() const noexcept { return body_; }
  [[nodiscard]] Real mean_entering() const noexcept { return transmittance_->mean(); }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    const Real internal = transmittance_->internal_reflectance();
    body_ = body_reflectance(this->diffuse_reflectance, internal, nonlinear, this->ior);
    this->derive_weights();
  }

 private:
  Rgb<Real> body_;
  const RoughTransmittance* transmittance_;  // of the scene's tables; all lanes share one
};

}  // namespace equaltime
