// What every light gives and takes. A light is sampled as seen from a receiving point; pdfs are per solid angle there.
// Radiance leaves a surface light from its front side only. The pick probability is not in these pdfs: LightTable adds
// it.
#pragma once

#include "math/spectrum.h"
#include "scene/interaction.h"

namespace equaltime {

struct LightSample {
  Vec3f wi;           // unit, from the receiver
  Spectrum radiance;  // arriving, before occlusion; for a point light already divided by distance²
  float pdf;          // includes the pick; for a point light the pick alone
  float distance;
  SurfaceAnchor target;   // its normal towards the receiver
  bool infinite = false;  // the light is a direction: target has no meaning
  bool delta = false;     // no other technique can find it
};

/// Radiance and density of a light that a scattered ray has met.
struct LightValue {
  Spectrum radiance;
  float pdf;
};

}  // namespace equaltime
