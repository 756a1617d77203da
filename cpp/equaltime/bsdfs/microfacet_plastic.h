// MicrofacetPlastic: the part that both rough plastics share: microfacets of a dielectric over a diffuse body.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/lobe_weights.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

/// Shares of light that an interface reflects, and lets into the body.
template <class Real>
struct InterfaceShares {
  Real reflected, entering;
};

/// `Model`, which derives from it, has
///   shares(cosine): the InterfaceShares of light from a direction outside;
///   body(): f·π of the body without the interface's transmittances;
///   mean_entering(): the transmittance of the interface for diffuse light from outside.
template <class Real, class Model>
struct MicrofacetPlastic {
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Microfacet<Real> distribution;
  Real ior;  // interior over exterior
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    const Optional<Vec3<Real>> m = facet_between(wo, wi, Real(1));
    return where(wi.z > 0 && m.has_value(), [&] { return eval_at(wo, wi, *m); });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real>, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    const auto value = [&](const Vec3<Real>& wi, const Vec3<Real>& m) noexcept { return eval_at(wo, wi, m); };
    return sample_specular_or_body(distribution, specular_probability(model().shares(wo.z)), wo, u_lobe, u, value);
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const InterfaceShares<Real> shares = model().shares(wo.z);
    return specular_reflectance * shares.reflected + model().body() * (shares.entering * model().mean_entering());
  }

 protected:
  template <class Description>
  MicrofacetPlastic(const Description& d, double alpha_u, double alpha_v) noexcept
      : distribution(d.distribution, static_cast<float>(alpha_u), static_cast<float>(alpha_v)),
        ior(static_cast<float>(d.ior)),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)) {}

  /// To be called when the body or a colour has changed.
  void derive_weights() noexcept {
    weights_ = {specular_reflectance.mean(), model().body().mean() * model().mean_entering()};
  }

 private:
  [[nodiscard]] const Model& model() const noexcept { return static_cast<const Model&>(*this); }
  [[nodiscard]] BsdfValue<Real> eval_at(const Vec3<Real>& wo, const Vec3<Real>& wi,
                                        const Vec3<Real>& m) const noexcept {
    const InterfaceShares<Real> shares = model().shares(wo.z);
    const Real specular = specular_probability(shares);
    // The cosine of half the angle between them, the same from both: where total reflection begins, Fresnel's
    // reflectance is so steep that the rounding of wo·m and wi·m would tell.
    const Real reflectance = fresnel_dielectric(min(Real(1), 0.5F * length(wo + wi)), ior).reflectance;
    const FacetLobe<Real> lobe = reflected(distribution, wo, wi, m);
    const Real cosine = cosine_hemisphere_pdf(wi.z);
    return {specular_reflectance * (reflectance * lobe.f) +
                model().body() * (cosine * shares.entering * model().shares(wi.z).entering),
            specular * lobe.pdf + (1 - specular) * cosine};
  }
  [[nodiscard]] Real specular_probability(const InterfaceShares<Real>& shares) const noexcept {
    return weights_.specular_probability(shares.reflected, shares.entering);
  }

  LobeWeights<Real> weights_;
};

}  // namespace equaltime
