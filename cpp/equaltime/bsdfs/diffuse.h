// Lambertian reflection: f = ρ/π.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct DiffuseDescription {
  Vec3d reflectance;
};

template <class Real>
struct Diffuse {
  using Description = DiffuseDescription;
  static constexpr const char* name = "diffuse";
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Rgb<Real> reflectance;

  explicit Diffuse(const Description& d) noexcept : reflectance(spectrum(d.reflectance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"reflectance", &Description::reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("reflectance", &Diffuse::reflectance)};
  }

  [[nodiscard]] BsdfValue<Real> eval(const Vec3<Real>&, const Vec3<Real>& wi, Mask<Real>) const noexcept {
    const Real pdf = cosine_hemisphere_pdf(wi.z);
    return {reflectance * pdf, pdf};
  }
  [[nodiscard]] Optional<BsdfSample<Real>> sample(const Vec3<Real>&, Mask<Real>, Double<Real>,
                                                  Point2<Real> u) const noexcept {
    const Vec3<Real> wi = square_to_cosine_hemisphere(u);
    return {{wi, reflectance, cosine_hemisphere_pdf(wi.z)}, wi.z > 0};
  }
  [[nodiscard]] Rgb<Real> albedo(const Vec3<Real>&, Mask<Real>) const noexcept { return reflectance; }
};

}  // namespace equaltime
