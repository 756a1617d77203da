// Events: what the estimator tells its observer, in the order in which it happens.
#pragma once

#include "equaltime/base/optional.h"
#include "equaltime/scene/shading.h"

namespace equaltime {

/// How the ray to the current vertex was made; see transport/gather.h.
struct PreviousVertex;

namespace event {

/// A path begins, at a place that the pixel filter gives this weight.
struct PathStarted {
  float filter_weight;
};

/// A ray of the path is about to be traced, at a time from 0 to 1, with the throughput that it carries and what the
/// path has gathered so far.
struct RayTraced {
  const Ray& ray;
  float time;
  const PreviousVertex& previous;
  Spectrum beta, L;
};

/// The ray has met this surface, or nothing.
struct RayHit {
  const Ray& ray;
  const Interaction* it;  // null: nothing
};

/// The ray has come through its medium, which leaves this of its throughput, to the surface that it met or, if the
/// medium scattered it, to a vertex before.
struct DistanceSampled {
  const Interaction* it;  // null: met nothing
  bool scattered;
  Spectrum beta;
};

/// The ray has met a surface that emits towards it; light sampling has this density for its direction.
struct EmitterHit {
  std::uint32_t light;
  float light_pdf;
};

/// What the path gathers from the emitter that its ray met, the path's depth-th vertex.
struct EmissionAdded {
  Spectrum L;
  std::uint32_t light;
  int depth;
};

/// The path is scattered by this BSDF.
struct VertexReached {
  Scatterer bsdf;
};

/// A light was picked, or none may reach the vertex.
struct LightPicked {
  Optional<SampledLight> pick;
};

/// A point or a direction of it was sampled, towards which the BSDF has this value.
struct LightSampled {
  const LightSample<float>& light;
  BsdfValue<float> bsdf;
};

/// Whether anything stands on a ray to a light.
struct ShadowRayTraced {
  const Ray& ray;
  float time;
  bool blocked;
};

/// The nearest surface on a ray to a light, which may let it pass.
struct ShadowRayHit {
  const Ray& ray;
  float time;
  const Interaction* it;  // null: nothing
};

/// MIS weight of the sampled light, and the fraction of it that reaches the vertex.
struct LightReceived {
  float weight, visibility;
};

/// What the path gathers from the sampled light, which would be its depth-th vertex if the way crosses no surface.
struct DirectLightAdded {
  Spectrum L;
  int depth;
};

/// At a vertex, the path has become the first of its copies.
struct PathSplit {};
/// The next copy leaves the vertex.
struct CopyResumed {
  Scatterer bsdf;
};

/// How the path goes on from a vertex; nothing, if it ends there.
struct DirectionSampled {
  const Interaction& it;
  std::uint32_t material;
  Scatterer bsdf;
  const Optional<ScatterSample>& scattered;
};

/// Roulette lets the path live with this probability.
struct RouletteSurvived {
  float probability;
};

}  // namespace event

}  // namespace equaltime
