// THE estimator: one path from the camera, with next-event estimation and BSDF sampling combined by MIS, or as the
// settings have it.
// Radiance is unbiased for any settings but a finite max_depth, which belongs to the problem. It never clamps, never
// drops a sample, never draws a number whose meaning depends on the order of calls.
#pragma once

#include <limits>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/path_copies.h"
#include "equaltime/transport/path_state.h"
#include "equaltime/transport/uncommon.h"

namespace equaltime {

/// What a path does where its ray has come to.
enum class Arrival : std::uint8_t { ends, crosses, scatters };

/// Adds what the ray has met that shines: a surface, or the environment if it has met nothing.
template <Effects E, class Probe>
EQUALTIME_INLINE void add_emission(const Scene& scene, const Settings& settings, PathState<E>& path,
                                   const Optional<Interaction>& it, Probe& probe) noexcept(!Probe::allocates) {
  if (it)
    path.L +=
        probe.met(path.beta * emitted<E>(scene, settings, *it, path.previous, probe), scene.light_of(*it), path.depth);
  else if (!path.straight.sees_no_environment(scene))
    path.L += probe.met(path.beta * escaped<E>(scene, settings, path.ray.direction, path.previous), scene.lights.last(),
                        path.depth);
}

/// Follows the ray through its medium to the next vertex, and adds what shines there. `own` keeps the vertex's BSDF
/// where that is no other's.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE Arrival arrive(const Scene& scene, const Settings& settings, PathState<E>& path,
                                              MeetingOf<E>& meeting, Vertex& v, std::optional<Bsdf>& own,
                                              Probe& probe) noexcept(!Probe::allocates) {
  const std::uint32_t segment = path.segment();
  const Bsdf* phase = path.within.follow(scene, path.ray, path.sampler, segment, path.beta, meeting);
  Optional<Interaction>& it = surface(meeting);
  if constexpr (Probe::listens) probe.note(event::Flies{it ? &*it : nullptr, phase != nullptr, path.beta});
  if constexpr (E.media || E.hidden_emitters)
    if (phase == nullptr && it &&
        (path.within.here().hides(scene, *it) || path.straight.looks_through(scene, *it, path.depth))) {
      path.cross(scene, *it, false);
      return Arrival::crosses;
    }
  if (phase == nullptr) {
    add_emission<E>(scene, settings, path, it, probe);
    if (!it) return Arrival::ends;
    v.material = scene.material(*it);
  }
  const bool crosses = E.masks && !scene.crossings_are_vertices;  // what is nothing, however long the path is
  if ((path.depth >= settings.max_depth && !crosses) || (phase == nullptr && v.material == kNone)) return Arrival::ends;
  if constexpr (E.masks) {
    if (phase == nullptr)
      v.material = scene.picked(v.material, *it, path.sampler.get_1d_precise(slot(BounceDimension::material, segment)));
    if (phase == nullptr && scene.materials[v.material].kind == Material::Kind::nothing) {
      path.cross(scene, *it, scene.crossings_are_vertices);
      return Arrival::crosses;
    }
  }
  v.bsdf = phase != nullptr
               ? phase
               : &path.within.here().beside(scene, *it, scene.bsdf<E>(v.material, *it, own, probe.time), own);
  v.may_cross = crosses && std::holds_alternative<ThinDielectric>(*v.bsdf);
  if (E.masks && path.depth >= settings.max_depth && !v.may_cross) return Arrival::ends;
  return Arrival::scatters;
}

/// Adds the light that reaches the vertex from a sampled light, and draws the direction in which the path goes on, if
/// it does.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE Optional<Scattering> scatter(const Scene& scene, const Settings& settings,
                                                            PathState<E>& path, const Interaction& it, const Vertex& v,
                                                            VertexNumbers u, PathCopies<E>& copies,
                                                            Probe& probe) noexcept(!Probe::allocates) {
  const std::uint32_t segment = path.segment();
  Optional<Scattering> scattered;
  if (is_delta<E>(*v.bsdf)) {
    scattered = sample_bsdf<E>(it, *v.bsdf, path.sampler, segment, {});
  } else if (is_uncommon(settings.technique)) [[unlikely]] {
    const TurnedVertex turned = uncommon_vertex<E>(scene, settings, it, *v.bsdf, path.within.here(), path.sampler,
                                                   segment, path.depth, u, probe);
    path.L += probe.lit(path.beta * turned.direct, path.depth + 1);
    path.previous.mixed = turned.mixed;
    scattered = turned.scattered;
  } else {
    if constexpr (!E.forks) scattered = sample_bsdf<E>(it, *v.bsdf, path.sampler, segment, u.bsdf_direction);
    const Spectrum direct = direct_light<E>(scene, settings, it, *v.bsdf, path.within.here(), path.sampler, segment,
                                            path.depth, u.light_point, probe);
    path.L += probe.lit(path.beta * direct, path.depth + 1);
    if constexpr (E.forks) {
      if (copies.due()) {
        copies.split(scene, it, *v.bsdf, path);
        u = path.sampler.vertex(segment);
        if constexpr (Probe::listens) probe.note(event::Forks{});
      }
      scattered = sample_bsdf<E>(it, *v.bsdf, path.sampler, segment, u.bsdf_direction);
    }
  }
  return scattered;
}

/// Whether Russian roulette lets the path live at the vertex.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE bool survives(const Settings& settings, PathState<E>& path, const Interaction& it,
                                             const Bsdf& bsdf, Probe& probe) noexcept(!Probe::allocates) {
  if (path.depth < settings.roulette_depth) return true;
  float survival = survival_probability(settings.roulette, settings.survival, path.beta * (1 / path.radiance_scale),
                                        [&]() noexcept { return albedo<E>(it, bsdf); });
  if (path.depth >= kEndlessDepth && settings.max_depth == kUnlimitedDepth) [[unlikely]]
    survival *= survival_of_endless(path.depth);
  if constexpr (Probe::listens) probe.note(event::Survives{survival});
  if (survival < 1 && path.sampler.get_1d_precise(slot(BounceDimension::roulette, path.segment())) >= survival)
    return false;
  path.beta *= 1 / survival;
  return true;
}

/// Leaves the vertex in the drawn direction; false if the path ends all the same.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE bool depart(const Scene& scene, const Settings& settings, PathState<E>& path,
                                           const Interaction& it, const Vertex& v, const Scattering& scattered,
                                           Probe& probe) noexcept(!Probe::allocates) {
  if (v.may_cross && !scattered.above) --path.depth, ++path.crossed;
  if (E.masks && path.depth >= settings.max_depth) return false;
  path.beta *= scattered.weight;
  path.radiance_scale *= scattered.radiance_scale;
  if (!(0 < path.beta.sum() && path.beta.sum() < std::numeric_limits<float>::infinity())) [[unlikely]] {
    if (path.beta.is_black()) return false;
    if (!path.beta.is_finite()) {  // The sample is not finite, and no roulette would end its path.
      path.L += path.beta;
      return false;
    }
  }
  if (!survives<E>(settings, path, it, *v.bsdf, probe)) return false;
  path.previous.from = receiver_at<E>(it, *v.bsdf);
  path.previous.pdf = scattered.pdf, path.previous.alone = scattered.delta;
  path.ray = it.spawn(scattered.wi, scattered.above);
  path.within.leave(scene, it, scattered.above);
  path.straight.scatters(*v.bsdf, scattered.above);
  ++path.depth;
  return true;
}

/// The radiance of a path that begins with a camera ray, and of all its copies.
template <Effects E, class Probe>
[[nodiscard]] Spectrum trace_path(const Scene& scene, const Settings& settings, const Ray& camera_ray,
                                  const Sampler& sampler, PathCopies<E> copies,
                                  Probe& probe) noexcept(!Probe::allocates) {
  PathState<E> path{camera_ray, sampler, PathSurroundings<E>(scene, camera_ray, probe.time)};
  std::optional<Bsdf> own;  // of the vertex; here, since it is large and is cleared where it is made
  for (;;) {
    if (path.segment() % kLongPath == kLongPath - 1 && probe.gives_up()) [[unlikely]]
      return path.L;
    const VertexNumbers u = path.sampler.vertex(path.segment());  // made while the ray is on its way
    if constexpr (Probe::listens) probe.note(event::Sends{path.ray, path.previous, path.beta, path.L});
    const Ray ray = path.ray;  // a copy: by reference it would hold all of the path in memory
    auto meeting = probe.template intersect<E>(scene, ray);
    Vertex v;
    const Arrival arrival = arrive<E>(scene, settings, path, meeting, v, own, probe);
    bool goes_on = arrival == Arrival::crosses;
    if (arrival == Arrival::scatters) [[likely]] {
      const Interaction& it = *surface(meeting);
      probe.scatters(*v.bsdf);
      const Optional<Scattering> scattered = scatter<E>(scene, settings, path, it, v, u, copies, probe);
      if constexpr (Probe::listens) probe.note(event::Scatters{it, v.material, *v.bsdf, scattered});
      goes_on = scattered && depart<E>(scene, settings, path, it, v, *scattered, probe);
    }
    if (!goes_on && !copies.pop(path, probe)) return path.L;
  }
}

}  // namespace equaltime
