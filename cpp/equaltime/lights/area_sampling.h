// Light surfaces that are sampled uniformly over an area of a plane: samples, their density per solid angle at the
// receiver, and the point in which a direction meets the plane.
#pragma once

#include <numbers>

#include "equaltime/base/optional.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

/// The sample of a point that was drawn uniformly over an area. `height` is the receiver's above the plane of the area,
/// and above 0: height / distance is the cosine at the light.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE LightSample<Real> area_sample(const Vec3<Real>& receiver, const OffsetPoint<Real>& point,
                                                             Real height, const Rgb<Real>& radiance, Real area,
                                                             Real pmf) noexcept {
  const Vec3<Real> to_light = point.p - receiver;
  const Real distance_squared = length_squared(to_light), distance = sqrt(distance_squared);
  const Real pdf = pmf * distance_squared * distance / (height * area);
  return {.wi = to_light * (1 / distance), .radiance = radiance, .pdf = pdf, .distance = distance, .target = point};
}

/// Density per solid angle at the receiver of `point`, drawn uniformly over an area with a unit normal; 0 from behind.
/// `wi` is the unit direction from the receiver to the point.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE Real area_pdf(const Vec3<Real>& receiver, const Vec3<Real>& wi, const Vec3<Real>& point,
                                             const Vec3<Real>& normal, Real area) noexcept {
  const Real cosine = -dot(normal, wi);
  return where(cosine > 0, [&] { return length_squared(point - receiver) / (cosine * area); });
}

/// A point of a plane: the plane's origin plus a·edge_u + b·edge_v.
template <class Real>
struct PlanePoint {
  Double<Real> a, b;
  Vec3<Real> point;
};

/// The point in which a direction meets the plane of an origin and two edges (Möller & Trumbore 1997, without the
/// triangle's limits); none if the plane is behind the receiver or parallel to the direction.
template <class Real>
[[nodiscard]] inline Optional<PlanePoint<Real>> plane_towards(Vec3<Real> receiver, Vec3<Real> wi,
                                                              const Vec3<Double<Real>>& origin,
                                                              const Vec3<Double<Real>>& edge_u,
                                                              const Vec3<Double<Real>>& edge_v) noexcept {
  const Vec3<Double<Real>> from(receiver), direction(wi), to_receiver = from - origin;
  const Vec3<Double<Real>> across = cross(direction, edge_v), along = cross(to_receiver, edge_u);
  const Double<Real> inverse = 1 / dot(edge_u, across), t = dot(edge_v, along) * inverse;
  const Mask<Real> ahead = t > 0 && t < kInfinity;
  if (none(ahead)) return std::nullopt;
  return {{dot(to_receiver, across) * inverse, dot(direction, along) * inverse, Vec3<Real>(from + direction * t)},
          ahead};
}

/// Power of a surface with an area that shines evenly from one side.
[[nodiscard]] inline double emitted_power(const Spectrum& radiance, double area) noexcept {
  return std::numbers::pi * area * static_cast<double>(radiance.mean());
}

}  // namespace equaltime
