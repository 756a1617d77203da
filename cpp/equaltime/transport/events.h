// Events: what the estimator tells its observer, in the order in which it happens.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/scene/shading.h"

namespace equaltime {

/// Sampling of the ray to the current vertex; see transport/gather.h.
struct PreviousVertex;

namespace event {

/// A path begins, at a place that the pixel filter gives this weight.
struct PathStarted {
  float filter_weight;
};

/// A ray of the path is about to be traced. `time` is in [0, 1]; `beta` is the throughput, `L` the radiance so far.
struct RayTraced {
  const Ray& ray;
  float time;
  const PreviousVertex& previous;
  Spectrum beta, L;
};

/// The nearest hit of the ray is known.
struct RayHit {
  const Ray& ray;
  const Interaction* it;  // null: nothing
};

/// A distance was sampled in the ray's medium. `beta` is the throughput after it. If `scattered`, the medium scattered
/// the ray before a surface, and `it` is the vertex there.
struct DistanceSampled {
  const Interaction* it;  // null: no hit
  bool scattered;
  Spectrum beta;
};

/// The ray has hit the emitting side of a surface. `light_pdf`: density of light sampling for the ray's direction.
struct EmitterHit {
  std::uint32_t light;
  float light_pdf;
};

/// Emission added to the path's radiance. The emitter is the path's depth-th vertex.
struct EmissionAdded {
  Spectrum L;
  std::uint32_t light;
  int depth;
};

/// In a dense medium, a ray has looked for the exact point of a light sample.
struct EmitterRayTraced {
  const Ray& ray;
  float time;
};

/// The path is at a vertex that scatters it.
struct VertexReached {
  Scatterer scatterer;
};

/// A light was picked; nothing if no light can reach the vertex.
struct LightPicked {
  Optional<PickedLight> pick;
};

/// A point or a direction of the light was sampled. `bsdf`: the BSDF's value towards it.
struct LightSampled {
  const LightSample<float>& light;
  BsdfValue<float> bsdf;
};

/// A shadow ray was traced; `blocked` if it hit any surface.
struct ShadowRayTraced {
  const Ray& ray;
  float time;
  bool blocked;
};

/// The nearest hit of a shadow ray is known; its surface may transmit light.
struct ShadowRayHit {
  const Ray& ray;
  float time;
  const Interaction* it;  // null: nothing
};

/// MIS weight of the sampled light, and the fraction of it that reaches the vertex.
struct LightReceived {
  float weight, visibility;
};

/// Light of the sampled light added to the path's radiance. `depth`: of the light as a vertex, if the shadow ray
/// crosses no surface.
struct DirectLightAdded {
  Spectrum L;
  int depth;
};

/// At a vertex, the path has become the first of its copies.
struct PathSplit {};
/// The next copy leaves the vertex.
struct CopyResumed {
  Scatterer scatterer;
};

/// A direction was sampled at a vertex; nothing if the path ends there.
struct DirectionSampled {
  const Interaction& it;
  std::uint32_t material;
  Scatterer scatterer;
  const Optional<ScatterSample>& scattered;
};

/// Roulette is about to let the path live with this probability.
struct RouletteBegun {
  float probability;
};

}  // namespace event

}  // namespace equaltime
