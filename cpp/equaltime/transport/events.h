// Events: what the estimator tells a probe that listens, in the order in which it happens. For one that does not, they
// are not even compiled, so that a kernel has no instruction of them.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/scene/shading.h"

namespace equaltime {

/// How the ray to the current vertex was made; see transport/gather.h.
struct PreviousVertex;

namespace event {

/// A ray is sent, with the throughput that it carries and what the path has gathered so far.
struct Sends {
  const Ray& ray;
  const PreviousVertex& made;
  Spectrum beta, L;
};

/// The ray has come through its medium, which leaves this of its throughput, to the surface that it met or, if the
/// medium scattered it, to a vertex before.
struct Flies {
  const Interaction* it;  // null: met nothing
  bool scattered;
  Spectrum beta;
};

/// The ray has met a surface that emits towards it; light sampling has this density for its direction.
struct MeetsEmitter {
  std::uint32_t light;
  float light_pdf;
};

/// A light was picked, or none may reach the vertex.
struct PicksLight {
  Optional<LightPick> pick;
};

/// A point or a direction of it was sampled, towards which the BSDF has this value.
struct SamplesLight {
  const LightSample& light;
  BsdfValue bsdf;
};

/// Of the sampled light: the weight of MIS, and the share that nothing blocks.
struct Receives {
  float weight, share;
};

/// At a vertex, the path has become the first of its copies.
struct Forks {};
/// The next copy leaves it.
struct Resumes {};

/// Going on from a vertex; nothing, if the path ends there.
struct Scatters {
  const Interaction& it;
  std::uint32_t material;
  const Bsdf& bsdf;
  const Optional<Scattering>& scattered;
};

/// Roulette lets the path live with this probability.
struct Survives {
  float probability;
};

}  // namespace event

}  // namespace equaltime
