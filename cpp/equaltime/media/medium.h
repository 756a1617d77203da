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

  /// Samples a scattering distance along a ray of throughput `beta`, which is not black, up to a surface at `distance`,
  /// or infinitely far. One channel is picked by its part of the throughput, and the balance heuristic weights all
  /// channels, so that the sum of the throughput's channels never grows. A medium that only absorbs is not sampled: it
  /// attenuates the ray.
  [[nodiscard]] DistanceSample sample(const Spectrum& beta, double distance, Point2d u) const noexcept;
};

}  // namespace equaltime
