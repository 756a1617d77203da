// Plastic without light that is reflected back into its body: microfacets of a dielectric over a diffuse body, which
// light enters and leaves by one refraction each. Mitsuba's model of polarised plastic, for light that is not.
#pragma once

#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/microfacet_plastic.h"

namespace equaltime {

struct PPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
};

template <class Real>
struct PPlastic : MicrofacetPlastic<Real, PPlastic<Real>> {
  using Description = PPlasticDescription;
  static constexpr const char* name = "pplastic";

  explicit PPlastic(const Description& d) noexcept
      : MicrofacetPlastic<Real, PPlastic>(d, d.alpha_u, d.alpha_v), mean_entering_(1 - fresnel_diffuse(this->ior)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &PPlasticDescription::distribution},
                      Field{"alpha_u", &PPlasticDescription::alpha_u, kRoughness},
                      Field{"alpha_v", &PPlasticDescription::alpha_v, kRoughness},
                      Field{"ior", &PPlasticDescription::ior, kIor},
                      Field{"diffuse_reflectance", &PPlasticDescription::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &PPlasticDescription::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("diffuse_reflectance", &PPlastic::diffuse_reflectance),
                                     color_slot("specular_reflectance", &PPlastic::specular_reflectance)},
                          textured_roughness());
  }

  [[nodiscard]] InterfaceShares<Real> shares(Real cosine) const noexcept {
    const Real reflectance = fresnel_dielectric(cosine, this->ior).reflectance;
    return {reflectance, 1 - reflectance};
  }
  [[nodiscard]] const Rgb<Real>& body() const noexcept { return this->diffuse_reflectance; }
  [[nodiscard]] Real mean_entering() const noexcept { return mean_entering_; }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept { this->derive_weights(); }

 private:
  Real mean_entering_;
};

}  // namespace equaltime
