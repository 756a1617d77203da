// Smooth plastic: a mirror of a dielectric's reflectance over a diffuse body, from which light leaves through the same
// interface, part of it only after it was reflected back into the body, once or more often. Mitsuba's model.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/bsdfs/fresnel.h"
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
[[nodiscard]] inline Spectrum body_reflectance(const Spectrum& rho, float internal, bool nonlinear,
                                               float ior) noexcept {
  const auto channel = [&](float r) noexcept {
    return r / ((1 - (nonlinear ? r * internal : internal)) * square(ior));
  };
  return {channel(rho.r), channel(rho.g), channel(rho.b)};
}

struct Plastic {
  using Description = PlasticDescription;
  static constexpr const char* name = "plastic";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = true;
  float ior;  // interior over exterior
  bool nonlinear;
  Spectrum diffuse_reflectance, specular_reflectance;

  explicit Plastic(const Description& d) noexcept
      : ior(static_cast<float>(d.ior)),
        nonlinear(d.nonlinear),
        diffuse_reflectance(spectrum(d.diffuse_reflectance)),
        specular_reflectance(spectrum(d.specular_reflectance)),
        internal_(fresnel_diffuse(1 / ior)),
        leaving_(square(ior) * (1 - internal_)) {
    derive();
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"ior", &PlasticDescription::ior, kIor},
                      Field{"diffuse_reflectance", &PlasticDescription::diffuse_reflectance, kShare},
                      Field{"specular_reflectance", &PlasticDescription::specular_reflectance, kShare},
                      Field{"nonlinear", &PlasticDescription::nonlinear}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("diffuse_reflectance", &Plastic::diffuse_reflectance),
                      color_slot("specular_reflectance", &Plastic::specular_reflectance)};
  }

  /// Of the body alone.
  [[nodiscard]] BsdfValue eval(const Vec3f& wo, const Vec3f& wi, bool) const noexcept {
    if (!(wi.z > 0)) return {};
    const float reflectance = interface(wo), cosine = cosine_hemisphere_pdf(wi.z);
    const float entering = (1 - reflectance) * (1 - interface(wi));
    return {body_ * (entering * cosine), (1 - share(reflectance)) * cosine};
  }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f& wo, bool front, double u_lobe, Point2f u) const noexcept {
    const float reflectance = interface(wo), mirror = share(reflectance);
    if (u_lobe < mirror)
      return BsdfSample{{-wo.x, -wo.y, wo.z}, specular_reflectance * (reflectance / mirror), 0, true};
    const Vec3f wi = square_to_cosine_hemisphere(u);
    const BsdfValue value = eval(wo, wi, front);
    if (!(value.pdf > 0)) return std::nullopt;
    return BsdfSample{wi, value.f * (1 / value.pdf), value.pdf};
  }
  [[nodiscard]] float delta_probability(const Vec3f& wo, bool) const noexcept { return share(interface(wo)); }
  [[nodiscard]] Spectrum albedo(const Vec3f& wo, bool) const noexcept {
    const float reflectance = interface(wo);
    return specular_reflectance * reflectance + body_ * ((1 - reflectance) * leaving_);
  }

  /// Computes all that follows from the two colours, which textures may give.
  void derive() noexcept {
    body_ = body_reflectance(diffuse_reflectance, internal_, nonlinear, ior);
    specular_ = specular_reflectance.mean();
    diffuse_ = body_.mean() * leaving_;
  }

 private:
  [[nodiscard]] float interface(const Vec3f& v) const noexcept { return fresnel_dielectric(v.z, ior).reflectance; }
  /// The mirror's share of what is scattered where the interface reflects so much.
  [[nodiscard]] float share(float reflectance) const noexcept {
    const float mirror = specular_ * reflectance, body = diffuse_ * (1 - reflectance);
    return mirror > 0 ? mirror / (mirror + body) : 0.0F;
  }

  float internal_;                    // the mean reflectance of the interface from within
  float leaving_;                     // the mean transmittance of the interface from outside
  Spectrum body_;                     // f·π of the body without the interface's transmittances
  float specular_ = 0, diffuse_ = 0;  // how much each scatters of what the interface gives it
};

}  // namespace equaltime
