// The steps of a path, in the order in which trace_path (path.h) takes them: arrive at a vertex, scatter there, depart.
#pragma once

#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/path_copies.h"
#include "equaltime/transport/path_state.h"
#include "equaltime/transport/techniques.h"

namespace equaltime {

/// How a path goes on at the end of a ray: it ends, crosses a surface that does not scatter, or scatters.
enum class Arrival : std::uint8_t { ends, crosses, scatters };

/// Adds the emission of the surface that the ray hits, or of the environment if there is no hit.
template <Effects E, Observer O>
EQUALTIME_INLINE void add_emission(const Scene& scene, const Settings& settings, PathState<E>& path,
                                   const Optional<Interaction>& it, O& observer) noexcept(!O::allocates) {
  if (!it && path.hidden_emitters.sees_no_environment(scene)) return;
  const Spectrum L = path.beta * (it ? surface_emission<E>(scene, settings, *it, path.previous, path.time, observer)
                                     : environment_emission<E>(scene, settings, path.ray.direction, path.previous));
  tell<event::EmissionAdded>(observer, L, it ? scene.geometry.light_of(*it) : scene.lights.environment_index(),
                             path.depth);
  path.L += L;
}

/// Whether the path goes through the surface as if it were not there: a dielectric of higher priority fills the place,
/// or the surface is an emitter that only the camera's path may not see.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE bool is_hidden(const Scene& scene, const PathState<E>& path,
                                              const Interaction& it) noexcept {
  return path.media.here().hides(scene.geometry, it.shape) || path.hidden_emitters.skips(scene, it, path.depth);
}

/// Decides what the surface does to the path: it ends it (absorbs, or lies beyond max_depth), lets it cross, or
/// scatters it by the BSDF that is put into `v`. `made` stores a BSDF that textures or an exterior dielectric make.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE Arrival meet_surface(const Scene& scene, const Settings& settings, PathState<E>& path,
                                                    Interaction& it, Vertex& v, std::optional<Bsdf>& made) noexcept {
  v.material = scene.geometry.material(it);
  // If crossings do not count, null surfaces and thin glass can still be crossed at max_depth. Thin glass is delta, so
  // that no direct light is added there.
  const bool crossings_do_not_count = E.masks && !scene.rules.count_null_interfaces;
  const bool absorbs = v.material == kNone;
  if ((path.at_max_depth(settings) && !crossings_do_not_count) || absorbs) return Arrival::ends;
  if constexpr (E.masks) {
    const double u = path.sampler.get_1d_precise(slot(BounceDecision::material, path.bounce()));
    v.material = scene.choose_component(v.material, it, u);
    if (scene.appearance.materials[v.material].kind == Material::Kind::null) {
      path.cross(scene, it, scene.rules.count_null_interfaces);
      return Arrival::crosses;
    }
  }
  scene.tilt_frame<E>(v.material, it, path.time);
  const Bsdf& bsdf = scene.bsdf<E>(v.material, it, made);
  v.scatterer = path.media.here().with_exterior(scene, it, bsdf, made);  // reads bsdf before it replaces `made`
  v.may_cross = crossings_do_not_count && v.scatterer.is_thin();
  if (E.masks && path.at_max_depth(settings) && !v.may_cross) return Arrival::ends;
  return Arrival::scatters;
}

/// Adds the emission of the surface that the ray hit, or of the environment, and finds the BSDF that scatters.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Arrival arrive_at_surface(const Scene& scene, const Settings& settings,
                                                         PathState<E>& path, Optional<Interaction>& it, Vertex& v,
                                                         std::optional<Bsdf>& made,
                                                         O& observer) noexcept(!O::allocates) {
  if constexpr (E.media || E.hidden_emitters)
    if (it && is_hidden(scene, path, *it)) {
      path.cross(scene, *it, false);
      return Arrival::crosses;
    }
  add_emission<E>(scene, settings, path, it, observer);
  return it ? meet_surface<E>(scene, settings, path, *it, v, made) : Arrival::ends;
}

/// Samples the distance to the next vertex, adds the emission there, and finds what scatters. `made` stores a BSDF that
/// textures or an exterior dielectric make.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Arrival arrive(const Scene& scene, const Settings& settings, PathState<E>& path,
                                              SurfaceIntersection<E>& hit, Vertex& v, std::optional<Bsdf>& made,
                                              O& observer) noexcept(!O::allocates) {
  const PhaseFunction* phase = path.media.sample_distance(scene, path.ray, path.sampler, path.bounce(), path.beta, hit);
  Optional<Interaction>& it = hit.it;
  tell<event::DistanceSampled>(observer, it ? &*it : nullptr, phase != nullptr, path.beta);
  if (phase == nullptr) return arrive_at_surface<E>(scene, settings, path, it, v, made, observer);
  v.scatterer = Scatterer(*phase);
  return path.at_max_depth(settings) ? Arrival::ends : Arrival::scatters;
}

template <Effects E, Observer O>
EQUALTIME_INLINE void add_direct_light(PathState<E>& path, const Spectrum& direct,
                                       O& observer) noexcept(!O::allocates) {
  const Spectrum L = path.beta * direct;
  tell<event::DirectLightAdded>(observer, L, path.depth + 1);
  path.L += L;
}

/// Adds the light that reaches the vertex from a sampled light, and draws the direction in which the path goes on, if
/// it does. Where paths are never split, the direction is drawn first, which compiles to less code.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Optional<ScatterSample> scatter(const Scene& scene, const Settings& settings,
                                                               PathState<E>& path, const Interaction& it,
                                                               const Vertex& v, VertexNumbers u, PathCopies<E>& copies,
                                                               O& observer) noexcept(!O::allocates) {
  const std::uint32_t bounce = path.bounce();
  Optional<ScatterSample> scattered;
  if (is_delta<E>(v.scatterer)) {
    scattered = sample_bsdf<E, true>(it, v.scatterer, path.sampler, bounce, {});
  } else if (replaces_bsdf_sampling(settings.technique)) [[unlikely]] {
    const Interaction it_copy = it;  // see sample_one_direction
    const Sampler sampler_copy = path.sampler;
    const VertexContext<E> vertex{.scene = scene,
                                  .settings = settings,
                                  .it = it_copy,
                                  .scatterer = v.scatterer,
                                  .media = path.media.here(),
                                  .sampler = sampler_copy,
                                  .bounce = bounce,
                                  .depth = path.depth,
                                  .time = path.time};
    const OneSampleEstimate estimate = sample_one_direction<E>(vertex, u, observer);
    add_direct_light<E>(path, estimate.direct, observer);
    path.previous.mixed = estimate.mixed;
    scattered = estimate.scattered;
  } else {
    if constexpr (!E.splitting)
      scattered = sample_bsdf<E, false>(it, v.scatterer, path.sampler, bounce, u.bsdf_direction);
    const VertexContext<E> vertex{.scene = scene,
                                  .settings = settings,
                                  .it = it,
                                  .scatterer = v.scatterer,
                                  .media = path.media.here(),
                                  .sampler = path.sampler,
                                  .bounce = bounce,
                                  .depth = path.depth,
                                  .time = path.time};
    const Spectrum direct = direct_light<E>(vertex, u.light_point, observer);
    add_direct_light<E>(path, direct, observer);
    if constexpr (E.splitting) {
      if (copies.due()) {
        copies.split(scene, it, v.scatterer, path);
        u = path.sampler.vertex(bounce);
        tell<event::PathSplit>(observer);
      }
      scattered = sample_bsdf<E, false>(it, v.scatterer, path.sampler, bounce, u.bsdf_direction);
    }
  }
  return scattered;
}

/// Plays Russian roulette: a path that survives has its throughput divided by the probability of that. Returns whether
/// it survives.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE bool play_roulette(const Settings& settings, PathState<E>& path, const Interaction& it,
                                                  Scatterer bsdf, O& observer) noexcept(!O::allocates) {
  if (path.depth < settings.roulette_depth) return true;
  float survival =
      survival_probability(settings.roulette, settings.survival, path.beta * (1 / path.hidden_from_roulette),
                           [&]() noexcept { return albedo<E>(it, bsdf); });
  if (path.depth >= kLongPathDepth && settings.max_depth == kUnlimitedDepth) [[unlikely]]
    survival *= long_path_survival(path.depth);
  tell<event::RouletteBegun>(observer, survival);
  if (survival < 1 && path.sampler.get_1d_precise(slot(BounceDecision::roulette, path.bounce())) >= survival)
    return false;
  path.beta *= 1 / survival;
  return true;
}

/// Applies throughput and roulette, and leaves the vertex in the sampled direction. Returns false if the path ends.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE bool depart(const Scene& scene, const Settings& settings, PathState<E>& path,
                                           const Interaction& it, const Vertex& v, const ScatterSample& scattered,
                                           O& observer) noexcept(!O::allocates) {
  if (v.may_cross && !scattered.above) path.count_as_crossed();
  if (E.masks && path.at_max_depth(settings)) return false;  // thin glass that was to be crossed, but reflects
  path.apply_weight(scattered);
  // One test on the usual way, of the sum. A sum may overflow although no component does: such a path goes on.
  if (!(0 < path.beta.sum() && path.beta.sum() < kInfinity)) [[unlikely]] {
    if (path.beta.is_black()) return false;
    if (!path.beta.is_finite()) {  // Makes the radiance not finite too, so that the renderer reports the sample.
      path.L += path.beta;
      return false;
    }
  }
  if (!play_roulette<E>(settings, path, it, v.scatterer, observer)) return false;
  path.leave(scene, it, v.scatterer, scattered);
  return true;
}

}  // namespace equaltime
