// Smooth plastic: a mirror of a dielectric's reflectance over a diffuse body, from which light leaves through the same
// interface, part of it only after it was reflected back into the body, once or more often. Mitsuba's model.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/bsdfs/lobe_weights.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct PlasticDescription {
  double ior = 1.5;  // interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
  bool nonlinear = false;  // light that is reflected within takes the colour of the body each time
};

/// What a diffuse body sends back, of all that entered it, to the interface: ρ/(1 - ρR) with R the reflectance of the
/// interface from within, and compressed by the refraction. Linear plastic takes ρ/(1 - R): no shift of colour.
template <class Real>
[[nodiscard]] inline Rgb<Real> body_reflectance(const Rgb<Real>& rho, Real internal, bool nonlinear,
                                                Real ior) noexcept {
  const auto channel = [&](Real r) noexcept { return r / ((1 - (nonlinear ? r * internal : internal)) * square(ior)); };
  return {channel(rho.r), channel(rho.g), channel(rho.b)};
}

template <class Real>
struct Plastic {
  using Description = PlasticDescription;
  static constexpr const char* name = "plastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  Real ior;  // interior over exterior
  bool nonlinear;
  Rgb<Real> diffuse_reflectance, specular_reflectance;

  explicit Plastic(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        nonlinear(d.nonlinear),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        internal_(fresnel_diffuse(1 / ior)),
        mean_entering_(square(ior) * (1 - internal_)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &Description::ior, kIor},
                      Field{"diffuse_reflectance", &Description::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &Description::specular_reflectance, kShare},
                      Field{"nonlinear", &Description::nonlinear}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("diffuse_reflectance", &Plastic::diffuse_reflectance),
                      color_slot("specular_reflectance", &Plastic::specular_reflectance)};
  }

  /// Of the body alone.
  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    return where(wi.z > 0, [&] {
      const Real reflectance = fresnel(wo), cosine = cosine_hemisphere_pdf(wi.z);
      const Real entering = (1 - reflectance) * (1 - fresnel(wi));
      return BsdfValue<Real>{body_ * (entering * cosine), (1 - specular_probability(reflectance)) * cosine};
    });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real> front, Double<Real> u_lobe,
                                                  Point2<Real> u) const noexcept {
    const Real reflectance = fresnel(wo), probability = specular_probability(reflectance);
    return where(
        u_lobe < Double<Real>(probability),
        [&] {
          const Rgb<Real> weight = specular_reflectance * (reflectance / probability);
          return Optional(BsdfSample<Real>{{-wo.x, -wo.y, wo.z}, weight, 0, true});
        },
        [&] {
          const Vec3<Real> wi = square_to_cosine_hemisphere(u);
          return sample_of(wi, eval(wo, wi, front), Mask<Real>(true));
        });
  }
  [[nodiscard]] Real delta_probability(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    return specular_probability(fresnel(wo));
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const Real reflectance = fresnel(wo);
    return specular_reflectance * reflectance + body_ * ((1 - reflectance) * mean_entering_);
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    body_ = body_reflectance(diffuse_reflectance, internal_, nonlinear, ior);
    weights_ = {specular_reflectance.mean(), body_.mean() * mean_entering_};
  }

 private:
  [[nodiscard]] Real fresnel(const Vec3<Real>& v) const noexcept { return fresnel_dielectric(v.z, ior).reflectance; }
  [[nodiscard]] Real specular_probability(Real reflectance) const noexcept {
    return weights_.specular_probability(reflectance, 1 - reflectance);
  }

  Real internal_;       // the mean reflectance of the interface from within
  Real mean_entering_;  // the mean transmittance of the interface from outside
  Rgb<Real> body_;      // f·π of the body without the interface's transmittances
  LobeWeights<Real> weights_;
};

}  // namespace equaltime
