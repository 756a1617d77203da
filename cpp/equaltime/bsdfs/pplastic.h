// Plastic without light that is reflected back into its body: microfacets of a dielectric over a diffuse body, which
// light enters and leaves by one refraction each. Mitsuba's model of polarised plastic, for light that is not.
#pragma once

#include "equaltime/bsdfs/microfacet_plastic.h"
#include "equaltime/bsdfs/texture_slots.h"

namespace equaltime {

struct PPlasticDescription {
  MicrofacetModel distribution = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1, ior = 1.5;  // ior: interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
};

template <class Real>
struct PPlastic {
  using Description = PPlasticDescription;
  static constexpr const char* name = "pplastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  explicit PPlastic(const Description& d) noexcept
      : distribution(d.distribution, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
        ior(static_cast<float>(d.ior)),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        mean_entering_(1 - fresnel_diffuse(ior)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"distribution", &Description::distribution},
                      Field{"alpha_u", &Description::alpha_u, kRoughness},
                      Field{"alpha_v", &Description::alpha_v, kRoughness},
                      Field{"ior", &Description::ior, kIor},
                      Field{"diffuse_reflectance", &Description::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple_cat(std::tuple{color_slot("diffuse_reflectance", &PPlastic::diffuse_reflectance),
                                     color_slot("specular_reflectance", &PPlastic::specular_reflectance)},
                          textured_roughness());
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
    const Real reflectance = fresnel_dielectric(cosine, ior).reflectance;
    return {reflectance, 1 - reflectance};
  }
  [[nodiscard]] const Rgb<Real>& body() const noexcept { return diffuse_reflectance; }
  [[nodiscard]] Real mean_entering() const noexcept { return mean_entering_; }
  [[nodiscard]] const LobeWeights<Real>& weights() const noexcept { return weights_; }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept { weights_ = plastic_weights(*this); }

 private:
  Real mean_entering_;
  LobeWeights<Real> weights_;
};

}  // namespace equaltime
