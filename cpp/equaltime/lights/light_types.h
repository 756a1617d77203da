// Types that all lights share. A light is sampled as seen from a receiving point; pdfs are per solid angle there.
// Radiance leaves a surface light from its front side only. The pdf of a light's `sample` includes the probability of
// the pick, which `sample` is given. A light's `pdf` does not include it: Lights multiplies by it.
#pragma once

#include "equaltime/math/spectrum.h"
#include "equaltime/shapes/interaction.h"

namespace equaltime {

/// A point that gathers light. Only the light tree looks beyond the point.
struct LightSampleContext {
  Vec3f p;
  Vec3f n;      // unit, as shaded, on the side that the point is seen from
  bool opaque;  // light from behind n counts for nothing
};

/// One of many lights, and the probability of this choice.
struct PickedLight {
  std::uint32_t light;
  float pmf;
};

template <class Real>
struct LightSample {
  Vec3<Real> wi;  // unit, from the receiver
  /// Arriving, before occlusion; for a point light already divided by distance². For a textured light its mean, from
  /// which Scene::radiance_of makes the radiance of the point.
  Rgb<Real> radiance;
  Real pdf;  // includes the pick; for a point light the pick alone
  Real distance;
  OffsetPoint<Real> target;     // its normal towards the receiver
  Mask<Real> infinite = false;  // the light is a direction: target has no meaning
  Mask<Real> delta = false;     // no other technique can find it
  Bits<Real> light = 0;         // its number
};

/// Radiance and density of a light that a scattered ray has met.
template <class Real>
struct LightValue {
  Rgb<Real> radiance;
  Real pdf;
};

}  // namespace equaltime
