// What microfacets scatter from wo to wi by single scattering, but for Fresnel's factor and colour (Walter et al. 2007,
// eq. 20 and 21). Local frame, wo above the surface; eta is the index of the far side over that of the side of wo.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

/// f·cosθi over the Fresnel factor, and the density of drawing a visible normal that scatters this way.
struct FacetLobe {
  float f, pdf;
};

/// The upward normal of the facets that mirror wo to wi above the surface, or refract it to wi below; none where both
/// directions cannot see its right sides.
[[nodiscard]] inline Optional<Vec3f> facet_between(const Vec3f& wo, const Vec3f& wi, float eta) noexcept {
  const bool mirrors = wi.z > 0;
  const Vec3f sum = mirrors ? wo + wi : wo + wi * eta;
  const float squared = length_squared(sum);
  if (!(squared > 0) || wi.z == 0) return std::nullopt;
  const Vec3f m = sum * ((sum.z < 0 ? -1.0F : 1.0F) / std::sqrt(squared));
  if (!(m.z > 0) || !(dot(wo, m) > 0) || (!mirrors && !(dot(wi, m) < 0))) return std::nullopt;
  return m;
}

[[nodiscard]] inline FacetLobe mirrored(const Microfacet& distribution, const Vec3f& wo, const Vec3f& wi,
                                        const Vec3f& m) noexcept {
  const float d = distribution.D(m);
  return {d * distribution.G1(wo) * distribution.G1(wi) / (4 * wo.z), distribution.reflected_pdf(wo, d)};
}

/// Samples a mirror direction of microfacets with this probability, by the smallest u_lobe, or else a direction of a
/// diffuse body beneath them. `value(wi, m)` evaluates both lobes, with the normal m between wo and wi.
template <class Value>
[[nodiscard]] EQUALTIME_INLINE Optional<BsdfSample> sample_mirror_or_body(const Microfacet& distribution,
                                                                          float probability, const Vec3f& wo,
                                                                          double u_lobe, Point2f u,
                                                                          Value&& value) noexcept {
  const bool mirrors = u_lobe < probability;
  const Vec3f m = mirrors ? distribution.sample(wo, u) : Vec3f();
  const Vec3f wi = mirrors ? m * (2 * dot(wo, m)) - wo : square_to_cosine_hemisphere(u);
  if (!(wi.z > 0)) return std::nullopt;
  const BsdfValue both = value(wi, mirrors ? m : normalize(wo + wi));
  if (!(both.pdf > 0)) return std::nullopt;
  return BsdfSample{wi, both.f * (1 / both.pdf), both.pdf};
}

/// With o and i the cosines of the directions to m: D·G·o·i / (cosθo (o - η·i)²), for radiance, whose compression by
/// 1/η² cancels the η² of the change of solid angle. Since refraction has o² - η²i² = 1 - η², the difference, which
/// cancels where η is near 1, need not be formed.
[[nodiscard]] inline FacetLobe refracted(const Microfacet& distribution, const Vec3f& wo, const Vec3f& wi,
                                         const Vec3f& m, float eta) noexcept {
  const float o = dot(wo, m), i = -dot(wi, m);
  const float stretch = i * square((o + eta * i) / ((1 - eta) * (1 + eta)));
  const float g = distribution.G1(wo) * distribution.G1({wi.x, wi.y, -wi.z});
  return {distribution.D(m) * g * o * stretch / wo.z, distribution.visible_pdf(wo, m) * stretch * square(eta)};
}

}  // namespace equaltime
