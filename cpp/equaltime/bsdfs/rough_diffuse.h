// A rough diffuse surface, as of plaster or clay: grooves of Lambertian facets that hide, shade and light one another.
// The model of Oren and Nayar ("Generalization of Lambert's reflectance model", SIGGRAPH 1994) is a fit to integrals
// over such grooves. It has the parameters of Mitsuba 0.6. Mitsuba's alpha is √2 times the paper's σ in radians.
//
// The fit is reciprocal, but does not keep energy: white surfaces scatter from 0.67 to 1.051 of the light, and from 0.5
// to 1.016 in the fast approximation. From an alpha of 0.93 the fit is below 0 where both directions graze the surface
// from opposite sides. It then counts as 0.
#pragma once

#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/diffuse.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct RoughDiffuseDescription {
  Vec3d reflectance{0.5, 0.5, 0.5};  // of a facet
  double alpha = 0.2;                // root mean square of the facets' slopes
  bool use_fast_approx = false;      // the paper's qualitative model: no light between facets
};

template <class Real>
struct RoughDiffuse {
  using Description = RoughDiffuseDescription;
  static constexpr const char* name = "roughdiffuse";
  static constexpr bool Effects::*needs = &Effects::layered;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Rgb<Real> reflectance;
  Real alpha;
  bool use_fast_approx;

  explicit RoughDiffuse(const Description& d) noexcept
      : reflectance(spectrum(d.reflectance)), alpha(static_cast<float>(d.alpha)), use_fast_approx(d.use_fast_approx) {
    derive();
  }
  /// Without roughness this is Lambertian reflection.
  [[nodiscard]] static std::optional<Diffuse<Real>> simpler(const Description& d) noexcept {
    if (static_cast<float>(d.alpha) > 0) return std::nullopt;
    return Diffuse<Real>(DiffuseDescription{d.reflectance});
  }
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"reflectance", &Description::reflectance, kShare},
                      Field{"alpha", &Description::alpha, kCoefficient},
                      Field{"use_fast_approx", &Description::use_fast_approx}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("reflectance", &RoughDiffuse::reflectance),
                      number_slot("alpha", &RoughDiffuse::alpha)};
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>& wo, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    return where(wi.z > 0, [&] {
      const Grooves g(wo, wi);
      const Real once = wi.z * lambert_ + spread_ * (use_fast_approx ? g.qualitative() : g.in_full());
      const Real twice = wi.z * interreflection_ * (1 - g.cos_phi * square(g.beta));
      // Each reflection takes the colour of the facets.
      const auto channel = [&](Real rho) noexcept { return kInvPi * rho * max(Real(0), once + rho * twice); };
      return BsdfValue<Real>{{channel(reflectance.r), channel(reflectance.g), channel(reflectance.b)},
                             cosine_hemisphere_pdf(wi.z)};
    });
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>& wo, Mask<Real> front, Double<Real>,
                                                  Point2<Real> u) const noexcept {
    const Vec3<Real> wi = square_to_cosine_hemisphere(u);
    return sample_of(wi, eval(wo, wi, front), Mask<Real>(true));
  }
  /// To 0.0011 if the model is nowhere below 0.
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>& wo, Mask<Real>) const noexcept {
    const Real once = lambert_ + spread_ * (use_fast_approx ? qualitative_albedo(wo) : full_albedo(wo.z));
    const auto channel = [&](Real rho) noexcept { return rho * (once + rho * interreflection_); };
    return {channel(reflectance.r), channel(reflectance.g), channel(reflectance.b)};
  }

  /// Computes all that follows from alpha, which a texture may give.
  void derive() noexcept {
    const Real variance = 0.5F * square(clamp(alpha, 0, 1e9F));  // σ²
    lambert_ = 1 - 0.5F * variance / (variance + 0.33F);
    spread_ = variance / (variance + 0.09F);
    interreflection_ = use_fast_approx ? Real(0) : 0.17F * variance / (variance + 0.13F);
  }

 private:
  [[nodiscard]] static Real sine(const Vec3<Real>& v) noexcept { return sqrt(square(v.x) + square(v.y)); }
  /// The angle from the normal, in right angles.
  [[nodiscard]] static Real angle(const Real& sine, const Real& cosine) noexcept {
    const auto of_lane = [](float s, float c) noexcept {
      return static_cast<float>(elementary::atan2(static_cast<double>(s), static_cast<double>(c)));
    };
    return 2 * kInvPi * for_each_lane<Real>(of_lane, sine, cosine);
  }

  /// The paper's angles of two directions: alpha and beta, the larger and the smaller from the normal, and phi between
  /// the azimuths. Both terms have the cosine of wi, which keeps them finite where both directions graze.
  struct Grooves {
    Real cos_i, cos_alpha, cos_beta, sin_alpha, sin_beta;
    Real sines_cos_phi;  // sinα·sinβ·cosφ
    Real cos_phi, beta;

    Grooves(const Vec3<Real>& wo, const Vec3<Real>& wi) noexcept
        : cos_i(wi.z),
          cos_alpha(min(wo.z, wi.z)),
          cos_beta(max(wo.z, wi.z)),
          sin_alpha(max(sine(wo), sine(wi))),
          sin_beta(min(sine(wo), sine(wi))),
          sines_cos_phi(wo.x * wi.x + wo.y * wi.y),
          cos_phi(
              where(sin_alpha * sin_beta > 0, [&] { return clamp(sines_cos_phi / (sin_alpha * sin_beta), -1, 1); })),
          beta(angle(sin_beta, cos_beta)) {}

    /// C2 cosφ tanβ cosθi of the qualitative model, without the spread.
    [[nodiscard]] Real qualitative() const noexcept { return 0.45F * max(Real(0), sines_cos_phi) * (cos_i / cos_beta); }
    /// (C2 cosφ tanβ + C3 (1 - |cosφ|) tan((α + β)/2)) cosθi, without the spread.
    [[nodiscard]] Real in_full() const noexcept {
      const Real apart = where(sines_cos_phi < 0, [&] { return square(beta) * beta / sin_alpha; });
      const Real both = square(angle(sin_alpha, cos_alpha) * beta);
      const Real half_tangent = cos_i / (cos_alpha + cos_beta) * (sin_alpha + sin_beta);
      return 0.45F * sines_cos_phi * (1 - apart) * (cos_i / cos_beta) +
             0.125F * both * (1 - abs(cos_phi)) * half_tangent;
    }
  };

  /// The integral of Grooves::qualitative over wi, divided by π.
  [[nodiscard]] static Real qualitative_albedo(const Vec3<Real>& wo) noexcept {
    const Real s = sine(wo), c = wo.z, theta = kPi / 2 * angle(s, c);
    return 0.3F * kInvPi * s * (1.5F * (theta - s * c) + c * (1 + s + s * s) / (1 + s));
  }
  /// The integral of Grooves::in_full over wi, divided by π: a fit, to 0.0011.
  [[nodiscard]] static Real full_albedo(Real cosine) noexcept {
    const Real x = sqrt(cosine);
    return 0.1776F - x * (0.0681F + x * (0.3367F - x * 0.2262F));
  }

  Real lambert_;          // C1
  Real spread_;           // σ²/(σ² + 0.09), of C2 and C3
  Real interreflection_;  // of light that two facets reflect
};

}  // namespace equaltime
