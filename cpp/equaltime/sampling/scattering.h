// Scattering: what a model of it tells of two directions, and what it draws.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/math/spectrum.h"
#include "equaltime/math/vector.h"

namespace equaltime {

/// f(wo, wi)·|cosθi| and the density with which `sample` would draw wi; both 0 for directions of measure zero.
template <class Real>
struct BsdfValue {
  Rgb<Real> f_cos;
  Real pdf = 0;
};

template <class Real>
struct BsdfSample {
  Vec3<Real> wi;
  Rgb<Real> weight;          // f·|cosθi| / pdf
  Real pdf = 0;              // meaningless if delta
  Mask<Real> delta = false;  // drawn from a discrete set: no other technique can find it
  Real eta_scale = 1.0F;     // the part of weight that is refraction's compression of radiance, for roulette
};

/// The sample of a direction that has this value, in the lanes of the mask whose density is above 0.
template <class Real>
[[nodiscard]] EQUALTIME_INLINE Optional<BsdfSample<Real>> sample_of(const Vec3<Real>& wi, const BsdfValue<Real>& value,
                                                                    Mask<Real> mask, Real eta_scale = 1) noexcept {
  const Mask<Real> drawn = mask && value.pdf > 0;
  if (none(drawn)) return std::nullopt;
  return {{wi, value.f_cos * (1 / value.pdf), value.pdf, false, eta_scale}, drawn};
}

}  // namespace equaltime
