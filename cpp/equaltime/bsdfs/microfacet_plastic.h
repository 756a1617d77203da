// The common part of both rough plastics: microfacets of a dielectric over a diffuse body. A model that uses it has
//   distribution, ior (interior over exterior) and specular_reflectance;
//   shares(cosine): what the interface reflects and lets in of light from a direction outside;
//   body(): f·π of the body without the interface's transmittances;
//   mean_entering(): the transmittance of the interface for diffuse light from outside;
//   weights(): the LobeWeights of both lobes, from plastic_weights.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/lobe_weights.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

/// Shares of light that an interface reflects, and transmits into the body.
template <class Real>
struct InterfaceShares {
  Real reflected, entering;
};

/// Weights of both lobes. A model computes them again when its body or a colour has changed.
template <template <class> class Model, class Real>
[[nodiscard]] inline LobeWeights<Real> plastic_weights(const Model<Real>& model) noexcept {
  return {model.specular_reflectance.mean(), model.body().mean() * model.mean_entering()};
}

namespace detail {
template <template <class> class Model, class Real>
[[nodiscard]] inline Real specular_probability(const Model<Real>& model, const InterfaceShares<Real>& shares) noexcept {
  return model.weights().specular_probability(shares.reflected, shares.entering);
}

template <template <class> class Model, class Real>
[[nodiscard]] inline BsdfValue<Real> eval_plastic_at(const Model<Real>& model, const Vec3<Real>& wo,
                                                     const Vec3<Real>& wi, const Vec3<Real>& m) noexcept {
  const InterfaceShares<Real> shares = model.shares(wo.z);
  const Real specular = specular_probability(model, shares);
  // wo·m = wi·m is computed as |wo + wi|/2, so that both directions have the same value. Where total reflection begins,
  // Fresnel's reflectance is so steep that their roundings would differ visibly.
  const Real reflectance = fresnel_dielectric(min(Real(1), 0.5F * length(wo + wi)), model.ior).reflectance;
  const FacetLobe<Real> lobe = reflected(model.distribution, wo, wi, m);
  const Real cosine = cosine_hemisphere_pdf(wi.z);
  return {model.specular_reflectance * (reflectance * lobe.f_cos) +
              model.body() * (cosine * shares.entering * model.shares(wi.z).entering),
          specular * lobe.pdf + (1 - specular) * cosine};
}
}  // namespace detail

template <template <class> class Model, class Real>
[[nodiscard]] inline BsdfValue<Real> eval_plastic(const Model<Real>& model, const Vec3<Real>& wo,
                                                  const Vec3<Real>& wi) noexcept {
  const Optional<Vec3<Real>> m = half_vector(wo, wi, Real(1));
  return where(wi.z > 0 && m.has_value(), [&] { return detail::eval_plastic_at(model, wo, wi, *m); });
}

template <template <class> class Model, class Real>
[[nodiscard]] inline Optional<BsdfSample<Real>> sample_plastic(const Model<Real>& model, const Vec3<Real>& wo,
                                                               Double<Real> u_lobe, Point2<Real> u) noexcept {
  const auto value = [&](const Vec3<Real>& wi, const Vec3<Real>& m) noexcept {
    return detail::eval_plastic_at(model, wo, wi, m);
  };
  const Real probability = detail::specular_probability(model, model.shares(wo.z));
  return sample_specular_or_body(model.distribution, probability, wo, u_lobe, u, value);
}

template <template <class> class Model, class Real>
[[nodiscard]] inline Rgb<Real> plastic_albedo(const Model<Real>& model, const Vec3<Real>& wo) noexcept {
  const InterfaceShares<Real> shares = model.shares(wo.z);
  return model.specular_reflectance * shares.reflected + model.body() * (shares.entering * model.mean_entering());
}

}  // namespace equaltime
