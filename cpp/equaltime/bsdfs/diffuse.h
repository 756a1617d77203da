// Lambertian reflection: f = ρ/π.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/fields.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

struct DiffuseDescription {
  Vec3d reflectance;
};

struct Diffuse {
  using Description = DiffuseDescription;
  static constexpr const char* name = "diffuse";
  static constexpr bool is_delta = false;
  static constexpr bool transmits = false;
  static constexpr bool picks_lobe = false;
  Spectrum reflectance;

  explicit Diffuse(const Description& d) noexcept : reflectance(spectrum(d.reflectance)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"reflectance", &DiffuseDescription::reflectance, kShare}};
  }
  [[nodiscard]] static constexpr auto textured() noexcept {
    return std::tuple{color_slot("reflectance", &Diffuse::reflectance)};
  }

  [[nodiscard]] BsdfValue eval(const Vec3f&, const Vec3f& wi, bool) const noexcept {
    const float pdf = cosine_hemisphere_pdf(wi.z);
    return {reflectance * pdf, pdf};
  }
  [[nodiscard]] Optional<BsdfSample> sample(const Vec3f&, bool, double, Point2f u) const noexcept {
    const Vec3f wi = square_to_cosine_hemisphere(u);
    if (!(wi.z > 0)) return std::nullopt;
    return BsdfSample{wi, reflectance, cosine_hemisphere_pdf(wi.z)};
  }
  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return reflectance; }
};

}  // namespace equaltime
