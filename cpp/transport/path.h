// THE estimator: one path from the camera, with next-event estimation and BSDF sampling combined by MIS, or as the
// settings have it.
// Radiance is unbiased for any settings but a finite max_depth, which belongs to the problem. It never clamps, never
// drops a sample, never draws a number whose meaning depends on the order of calls.
#pragma once

#include "scene/shading.h"
#include "transport/effects.h"
#include "transport/settings.h"
#include "transport/shadow.h"

namespace equaltime {

/// How the ray to the current vertex was made: what the MIS weight of an emitter that it meets depends on.
struct Arrival {
  Receiver from{};    // the vertex that it left
  float pdf = 0;      // per solid angle
  bool alone = true;  // no other technique can make this ray: camera rays and discrete directions
};

/// One-sample MIS divides by the density of the mixture, ½(p + q): p's own share ½p of it is the balance heuristic.
[[nodiscard]] inline Heuristic weighting(const Settings& s) noexcept {
  return s.technique == Technique::mixture ? Heuristic::balance : s.heuristic;
}

/// The weight of an emitter met by a scattered ray, given the density of light sampling for the same direction.
[[nodiscard]] inline float emitter_weight(const Settings& s, const Arrival& ray, float light_pdf) noexcept {
  if (ray.alone || !aims_at_lights(s.technique)) return 1;
  if (s.technique == Technique::light) return light_pdf > 0 ? 0.0F : 1.0F;
  return mis_weight(weighting(s), ray.pdf, light_pdf);
}

/// Radiance that the surface itself sends back along the ray.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE Spectrum emitted(const Scene& scene, const Settings& settings, const Interaction& it,
                                                const Arrival& ray) noexcept {
  const Surface& surface = scene.surfaces[it.shape];
  if (surface.first_light == kNone || !it.front) return {};
  float light_pdf = 0;
  if (!ray.alone && aims_at_lights(settings.technique))
    light_pdf = scene.lights.area_pdf<E>(settings.lights, scene.light_of(it), ray.from, -it.wo, it.anchor.p);
  return surface.radiance * emitter_weight(settings, ray, light_pdf);
}

template <Effects E>
[[nodiscard]] Spectrum escaped(const Scene& scene, const Settings& settings, const Ray& ray,
                               const Arrival& made) noexcept {
  if constexpr (E.environment) {
    if (!scene.lights.environment()) return {};
    const LightValue value = scene.lights.environment_towards(settings.lights, made.from, ray.direction);
    return value.radiance * emitter_weight(settings, made, value.pdf);
  }
  return {};
}

/// Light that reaches the vertex straight from one sampled light, scattered towards wo.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light(const Scene& scene, const Settings& settings,
                                                     const Interaction& it, const Bsdf& bsdf, const Sampler& sampler,
                                                     std::uint32_t bounce, Point2f u, Probe& probe) noexcept {
  // Where only scattered rays look for light, all that they cannot find are point lights.
  const bool aims = aims_at_lights(settings.technique);
  if (!E.point_lights && !aims) return {};
  auto light = scene.lights.sample<E>(settings.lights, receiver_at<E>(it, bsdf), sampler, bounce, u);
  if (!light || (!aims && !light->delta)) return {};
  auto [value, above] = eval_bsdf<E>(it, bsdf, light->wi);
  if (value.f.is_black()) return {};
  const bool shared = settings.technique != Technique::light && !light->delta;
  const float weight = shared ? mis_weight(weighting(settings), light->pdf, value.pdf) : 1.0F;
  Spectrum unoccluded = value.f * light->radiance * (weight / light->pdf);
  const int crossings = settings.max_depth - static_cast<int>(bounce) - 2;
  const float share = unblocked<E>(scene, it, above, *light, crossings, probe);
  return share > 0 ? unoccluded * share : Spectrum();
}

/// What a vertex sends back by itself, and how the path goes on.
struct Vertex {
  Spectrum direct;
  Optional<Scattering> scattered;
};

/// The techniques that do not look for direct light at every vertex and go on by the BSDF. `mixture` does one of the
/// two, each with probability ½ and at double weight: a path whose turn is light ends there. Out of line: inlined, what
/// others do not use cost them 4 %.
template <Effects E, class Probe>
[[nodiscard, gnu::noinline]] Vertex uncommon_vertex(const Scene& scene, const Settings& settings, const Interaction& it,
                                                    const Bsdf& bsdf, const Sampler& sampler, std::uint32_t bounce,
                                                    const VertexNumbers& u, Probe& probe) noexcept {
  const auto direct = [&]() noexcept {
    return direct_light<E>(scene, settings, it, bsdf, sampler, bounce, u.light_point, probe);
  };
  if (settings.technique == Technique::uniform)
    return {direct(), sample_uniform<E>(it, bsdf, sampler, bounce, u.bsdf_direction)};
  if (sampler.get_1d(slot(BounceDimension::technique, bounce)) < 0.5F) return {2 * direct(), std::nullopt};
  auto scattered = sample_bsdf<E>(it, bsdf, sampler, bounce, u.bsdf_direction);
  if (scattered) scattered->weight *= 2;
  return {{}, scattered};
}

template <Effects E, class Probe>
[[nodiscard]] Spectrum trace_path(const Scene& scene, const Settings& settings, const Ray& camera_ray,
                                  const Sampler& sampler, Probe& probe) noexcept {
  Ray ray = camera_ray;
  Spectrum L, beta(1);
  float radiance_scale = 1;  // of beta, by refraction: no reason to end a path
  Arrival made;
  for (int depth = 1;; ++depth) {
    const auto bounce = static_cast<std::uint32_t>(depth - 1);
    VertexNumbers u = sampler.vertex(bounce);  // made while the ray is on its way
    auto it = probe.template intersect<E>(scene, ray);
    if (!it) return L + beta * escaped<E>(scene, settings, ray, made);
    L += beta * emitted<E>(scene, settings, *it, made);
    std::uint32_t material = scene.material(*it);
    if (depth >= settings.max_depth || material == kNone) return L;
    if constexpr (E.masks) {
      material = scene.picked(material, *it, sampler.get_1d(slot(BounceDimension::material, bounce)));
      if (scene.materials[material].kind == Material::Kind::nothing) {
        ray = it->spawn(-it->wo, false);  // goes on as it arrived
        continue;
      }
    }
    std::optional<Bsdf> own;
    const Bsdf* bsdf = &scene.bsdf<E>(material, *it, own);
    Optional<Scattering> scattered;
    if (is_delta<E>(*bsdf)) {
      scattered = sample_bsdf<E>(*it, *bsdf, sampler, bounce, {});
    } else if (is_uncommon(settings.technique)) [[unlikely]] {
      const auto [direct, next] = uncommon_vertex<E>(scene, settings, *it, *bsdf, sampler, bounce, u, probe);
      L += beta * direct;
      scattered = next;
    } else {
      scattered = sample_bsdf<E>(*it, *bsdf, sampler, bounce, u.bsdf_direction);
      L += beta * direct_light<E>(scene, settings, *it, *bsdf, sampler, bounce, u.light_point, probe);
    }
    if (!scattered) return L;
    beta *= scattered->weight;
    radiance_scale *= scattered->radiance_scale;
    if (beta.is_black()) return L;
    if (depth >= settings.roulette_depth) {
      const float survival = survival_probability(settings.roulette, settings.survival, beta * (1 / radiance_scale),
                                                  [&]() noexcept { return albedo<E>(*it, *bsdf); });
      if (survival < 1 && sampler.get_1d_precise(slot(BounceDimension::roulette, bounce)) >= survival) return L;
      beta *= 1 / survival;
    }
    made = {receiver_at<E>(*it, *bsdf), scattered->pdf, scattered->delta};
    ray = it->spawn(scattered->wi, scattered->above);
  }
}

}  // namespace equaltime
