// Scattering: what a model of it tells of two directions, and what it draws.
#pragma once

#include "equaltime/math/spectrum.h"
#include "equaltime/math/vector.h"

namespace equaltime {

/// f(wo, wi)·|cosθi| and the density with which `sample` would draw wi; both 0 for directions of measure zero.
struct BsdfValue {
  Spectrum f;
  float pdf = 0;
};

struct BsdfSample {
  Vec3f wi;
  Spectrum weight;         // f·|cosθi| / pdf
  float pdf = 0;           // meaningless if delta
  bool delta = false;      // drawn from a discrete set: no other technique can find it
  float eta_scale = 1.0F;  // the part of weight that is refraction's compression of radiance, for roulette
};

}  // namespace equaltime
