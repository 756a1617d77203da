// THE estimator: one path from the camera, with next-event estimation and BSDF sampling combined by MIS, or as the
// settings have it.
// Radiance is unbiased for any settings but a finite max_depth, which belongs to the problem. It never clamps, never
// drops a sample, never draws a number whose meaning depends on the order of calls.
#pragma once

#include <limits>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/forks.h"
#include "equaltime/transport/hidden.h"
#include "equaltime/transport/uncommon.h"

namespace equaltime {

/// Returns the path's radiance. After a fork: the radiance of all copies traced so far.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE Spectrum trace_branch(const Scene& scene, const Settings& settings,
                                                     const Ray& camera_ray, NumbersOf<E> sampler, Forks<E>& forks,
                                                     Probe& probe) noexcept(!Probe::allocates) {
  Ray ray = camera_ray;
  Spectrum L, beta(1);
  float radiance_scale = 1;  // of beta, by refraction: no reason to end a path
  Arrival made;
  PathSurroundings<E> within(scene, ray, probe.time);
  std::uint32_t crossed = 0;  // surfaces that are no vertices
  int depth = 1;
  StraightAhead<E> straight(true);
  if constexpr (E.forks)
    if (const Departure<E>* copy = forks.taken()) {
      L = forks.gathered(), ray = copy->ray, made = copy->made, within = copy->within, sampler = copy->sampler;
      beta = copy->beta, radiance_scale = copy->radiance_scale, depth = copy->depth, crossed = copy->crossed;
      straight = StraightAhead<E>(false);
      probe.scatters(forks.bsdf());
      if constexpr (Probe::listens) probe.note(event::Resumes{});
    }
  for (;; ++depth) {
    const std::uint32_t bounce = static_cast<std::uint32_t>(depth - 1) + crossed;
    if (bounce % kLongPath == kLongPath - 1 && probe.gives_up()) [[unlikely]]
      return L;
    VertexNumbers u = sampler.vertex(bounce);  // made while the ray is on its way
    if constexpr (Probe::listens) probe.note(event::Sends{ray, made, beta, L});
    auto meeting = probe.template intersect<E>(scene, ray);
    const Bsdf* phase = within.follow(scene, ray, sampler, bounce, beta, meeting);
    Optional<Interaction>& it = surface(meeting);
    if constexpr (Probe::listens) probe.note(event::Flies{it ? &*it : nullptr, phase != nullptr, beta});
    if constexpr (E.media || E.hidden_emitters)
      if (phase == nullptr && it && (within.here().hides(scene, *it) || straight.looks_through(scene, *it, depth))) {
        ray = it->spawn(-it->wo, false);
        within.leave(scene, *it, false);
        --depth, ++crossed;
        continue;
      }
    std::uint32_t material = kNone;
    if (phase == nullptr) {
      if (!it && straight.sees_no_environment(scene)) return L;
      if (!it) return L + probe.met(beta * escaped<E>(scene, settings, ray, made), scene.lights.last(), depth);
      L += probe.met(beta * emitted<E>(scene, settings, *it, made, probe), scene.light_of(*it), depth);
      material = scene.material(*it);
    }
    const bool crosses = E.masks && !scene.crossings_are_vertices;  // what is nothing, however long the path is
    if ((depth >= settings.max_depth && !crosses) || (phase == nullptr && material == kNone)) return L;
    if constexpr (E.masks) {
      if (phase == nullptr)
        material = scene.picked(material, *it, sampler.get_1d_precise(slot(BounceDimension::material, bounce)));
      if (phase == nullptr && scene.materials[material].kind == Material::Kind::nothing) {
        ray = it->spawn(-it->wo, false);  // goes on as it arrived
        within.leave(scene, *it, false);
        if (!scene.crossings_are_vertices) --depth, ++crossed;
        continue;
      }
    }
    std::optional<Bsdf> own;
    const Bsdf* bsdf = phase != nullptr
                           ? phase
                           : &within.here().beside(scene, *it, scene.bsdf<E>(material, *it, own, probe.time), own);
    const bool may_cross = crosses && std::holds_alternative<ThinDielectric>(*bsdf);  // and is a vertex if it reflects
    if (E.masks && depth >= settings.max_depth && !may_cross) return L;
    probe.scatters(*bsdf);
    Optional<Scattering> scattered;
    if (is_delta<E>(*bsdf)) {
      scattered = sample_bsdf<E>(*it, *bsdf, sampler, bounce, {});
    } else if (is_uncommon(settings.technique)) [[unlikely]] {
      const Vertex vertex =
          uncommon_vertex<E>(scene, settings, *it, *bsdf, within.here(), sampler, bounce, depth, u, probe);
      L += probe.lit(beta * vertex.direct, depth + 1);
      scattered = vertex.scattered;
      made.mixed = vertex.mixed;
    } else {
      if constexpr (!E.forks) scattered = sample_bsdf<E>(*it, *bsdf, sampler, bounce, u.bsdf_direction);
      const Spectrum direct =
          direct_light<E>(scene, settings, *it, *bsdf, within.here(), sampler, bounce, depth, u.light_point, probe);
      L += probe.lit(beta * direct, depth + 1);
      if constexpr (E.forks) {
        if (forks.due()) {
          Departure<E> path{ray, beta, radiance_scale, made, within, depth, crossed, sampler};
          forks.fork(scene, *it, *bsdf, bounce, path);
          beta = path.beta, radiance_scale = path.radiance_scale, sampler = path.sampler, u = sampler.vertex(bounce);
          if constexpr (Probe::listens) probe.note(event::Forks{});
        }
        scattered = sample_bsdf<E>(*it, *bsdf, sampler, bounce, u.bsdf_direction);
      }
    }
    if constexpr (Probe::listens) probe.note(event::Scatters{*it, material, *bsdf, scattered});
    if (!scattered) return L;
    if (may_cross && !scattered->above) --depth, ++crossed;
    if (E.masks && depth >= settings.max_depth) return L;
    beta *= scattered->weight;
    radiance_scale *= scattered->radiance_scale;
    if (!(0 < beta.sum() && beta.sum() < std::numeric_limits<float>::infinity())) [[unlikely]] {
      if (beta.is_black()) return L;
      if (!beta.is_finite()) return L + beta;  // The sample is not finite, and no roulette would end its path.
    }
    if (depth >= settings.roulette_depth) {
      float survival = survival_probability(settings.roulette, settings.survival, beta * (1 / radiance_scale),
                                            [&]() noexcept { return albedo<E>(*it, *bsdf); });
      if (depth >= kEndlessDepth && settings.max_depth == kUnlimitedDepth) [[unlikely]]
        survival *= survival_of_endless(depth);
      if constexpr (Probe::listens) probe.note(event::Survives{survival});
      if (survival < 1 && sampler.get_1d_precise(slot(BounceDimension::roulette, bounce)) >= survival) return L;
      beta *= 1 / survival;
    }
    made.from = receiver_at<E>(*it, *bsdf), made.pdf = scattered->pdf, made.alone = scattered->delta;
    ray = it->spawn(scattered->wi, scattered->above);
    within.leave(scene, *it, scattered->above);
    straight.scatters(*bsdf, scattered->above);
  }
}

/// All of a path.
template <Effects E, class Probe>
[[nodiscard]] Spectrum trace_path(const Scene& scene, const Settings& settings, const Ray& camera_ray,
                                  const Sampler& sampler, Forks<E> forks, Probe& probe) noexcept(!Probe::allocates) {
  Spectrum L = trace_branch<E>(scene, settings, camera_ray, sampler, forks, probe);
  if constexpr (E.forks)
    while (forks.take(L)) L = trace_branch<E>(scene, settings, camera_ray, sampler, forks, probe);
  return L;
}

}  // namespace equaltime
