// Medium: what light passes through between surfaces, the same everywhere. Lengths are normalised.
#pragma once

#include <cstdint>

#include "equaltime/math/point.h"
#include "equaltime/math/spectrum.h"

namespace equaltime {

/// How far a ray comes in a medium, and what its throughput is multiplied by.
struct DistanceSample {
  double distance;
  bool scattered;  // with a particle, before the surface
  Spectrum weight;
};

struct Medium {
  Spectrum sigma_t;  // extinction per unit of length
  Spectrum sigma_s;  // the part of it that is scattering

  /// What is left of light after a distance, which may be infinite.
  [[nodiscard]] Spectrum transmittance(double distance) const noexcept;

  /// The flight of a ray of throughput `beta`, which is not black, to a surface at `distance`, or infinitely far. Where
  /// it scattered is drawn for one colour, picked by what is left of it, and weighted by the mean density of all
  /// colours so picked (the balance heuristic): the sum of the throughput's colours never grows. A medium that only
  /// absorbs is not sampled: the light is weakened.
  [[nodiscard]] DistanceSample sample(const Spectrum& beta, double distance, Point2d u) const noexcept;
};

}  // namespace equaltime
