// What microfacets scatter from wo to wi by single scattering, but for Fresnel's factor and colour (Walter et al. 2007,
// eq. 20 and 21). Local frame, wo above the surface; eta is the index of the far side over that of the side of wo.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/microfacet.h"
#include "equaltime/sampling/scattering.h"
#include "equaltime/sampling/warps.h"

namespace equaltime {

/// f·cosθi over the Fresnel factor, and the density of drawing a visible normal that scatters this way.
template <class Real>
struct FacetLobe {
  Real f_cos, pdf;
};

/// The upward normal of the facets that reflect wo to wi above the surface, or refract it to wi below; none where both
/// directions cannot see its right sides.
template <class Real>
[[nodiscard]] inline Optional<Vec3<Real>> half_vector(const Vec3<Real>& wo, const Vec3<Real>& wi, Real eta) noexcept {
  const Mask<Real> reflects = wi.z > 0;
  const Vec3<Real> sum = where(
      reflects, [&] { return wo + wi; }, [&] { return wo + wi * eta; });
  const Real squared = length_squared(sum);
  const Mask<Real> exists = squared > 0 && wi.z != 0;
  if (none(exists)) return std::nullopt;
  const Vec3<Real> m = sum * (select(sum.z < 0, Real(-1), Real(1)) / sqrt(squared));
  return {m, exists && m.z > 0 && dot(wo, m) > 0 && (reflects || dot(wi, m) < 0)};
}

template <class Real>
[[nodiscard]] inline FacetLobe<Real> reflected(const Microfacet<Real>& distribution, const Vec3<Real>& wo,
                                               const Vec3<Real>& wi, const Vec3<Real>& m) noexcept {
  const Real d = distribution.D(m);
  return {d * distribution.G1(wo) * distribution.G1(wi) / (4 * wo.z), distribution.reflected_pdf(wo, d)};
}

/// Samples a direction that microfacets reflect to with this probability, by the smallest u_lobe, or else a direction
/// of a diffuse body beneath them. `value(wi, m)` evaluates both lobes, with the normal m between wo and wi.
template <class Real, class Value>
[[nodiscard]] EQUALTIME_INLINE Optional<BsdfSample<Real>> sample_specular_or_body(const Microfacet<Real>& distribution,
                                                                                  Real probability,
                                                                                  const Vec3<Real>& wo,
                                                                                  Double<Real> u_lobe, Point2<Real> u,
                                                                                  Value&& value) noexcept {
  const Mask<Real> reflects = u_lobe < Double<Real>(probability);
  const Vec3<Real> facet = where(reflects, [&] { return distribution.sample(wo, u); });
  const Vec3<Real> wi = where(
      reflects, [&] { return facet * (2 * dot(wo, facet)) - wo; }, [&] { return square_to_cosine_hemisphere(u); });
  const Mask<Real> upper = wi.z > 0;
  if (none(upper)) return std::nullopt;
  const Vec3<Real> m = where(
      reflects, [&] { return facet; }, [&] { return normalize(wo + wi); });
  return sample_of(wi, value(wi, m), upper);
}

/// With o and i the cosines of the directions to m: D·G·o·i / (cosθo (o - η·i)²), for radiance, whose compression by
/// 1/η² cancels the η² of the change of solid angle. Since refraction has o² - η²i² = 1 - η², the difference, which
/// cancels where η is near 1, need not be formed.
template <class Real>
[[nodiscard]] inline FacetLobe<Real> refracted(const Microfacet<Real>& distribution, const Vec3<Real>& wo,
                                               const Vec3<Real>& wi, const Vec3<Real>& m, Real eta) noexcept {
  const Real o = dot(wo, m), i = -dot(wi, m);
  const Real stretch = i * square((o + eta * i) / ((1 - eta) * (1 + eta)));
  const Real g = distribution.G1(wo) * distribution.G1({wi.x, wi.y, -wi.z});
  return {distribution.D(m) * g * o * stretch / wo.z, distribution.visible_pdf(wo, m) * stretch * square(eta)};
}

}  // namespace equaltime
