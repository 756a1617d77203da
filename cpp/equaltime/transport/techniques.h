// The techniques that do not look for direct light at every vertex and go on by the BSDF: uniform directions, and
// one-sample MIS (Veach 1997, §9.2.4), which draws one direction either by the BSDF or towards a light, and follows it.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/transport/gather.h"

namespace equaltime {

/// What a vertex sends back by itself, and how the path goes on.
struct OneSampleVertex {
  Spectrum direct;
  Optional<ScatterSample> scattered;
  OneSampleMis mixed{};
};

/// One-sample MIS of the BSDF and one picked light. The throughput is divided by the mean of both pdfs. Each pick is
/// therefore unbiased by itself, and no other light's pdf is needed. `emission_mis_weight` says which emitters count
/// that the ray then meets. A delta light is sampled as ever, and the BSDF draws every direction.
template <Effects E, Observer O>
[[nodiscard]] OneSampleVertex mixture_vertex(const Scene& scene, const Settings& settings, const Interaction& it,
                                             Scatterer bsdf, MediumStack<E> media, const Sampler& sampler,
                                             std::uint32_t bounce, int depth, VertexNumbers u, float time,
                                             O& observer) noexcept(!O::allocates) {
  const LightSampleContext receiver = receiver_at<E>(it, bsdf);
  const auto picked = scene.lights.pick(settings.lights, receiver, sampler, bounce);
  tell<event::LightPicked>(observer, picked);
  const bool has_directions = picked && scene.lights.has_directions<E>(picked->light, receiver, time);
  const bool from_light = sampler.get_1d(slot(BounceDimension::technique, bounce)) < 0.5F;
  OneSampleVertex vertex;
  if (from_light && has_directions) {
    const auto light = scene.lights.sample<E>(SampledLight{picked->light, 1}, settings.environment, receiver, sampler,
                                              bounce, u.light_point, time);
    if (!light) return vertex;
    const auto [value, above] = eval_bsdf<E>(it, bsdf, light->wi);
    vertex.mixed = {picked->light, value.pdf + light->pdf};
    const Spectrum weight = value.f * (2 / vertex.mixed.pdf_sum);
    if (!value.f.is_black()) vertex.scattered = ScatterSample{light->wi, above, weight, value.pdf, false, 1};
    return vertex;
  }
  if (picked && !has_directions) {
    const auto point =
        scene.lights.sample<E>(*picked, settings.environment, receiver, sampler, bounce, u.light_point, time);
    if (point) vertex.direct = direct_light_from<E>(scene, settings, it, bsdf, media, *point, depth, time, observer);
  }
  auto scattered = sample_bsdf<E>(it, bsdf, sampler, bounce, u.bsdf_direction);
  if (!scattered) return vertex;
  float light_pdf = scattered->pdf;  // where both turns are the BSDF's
  if (has_directions) {
    light_pdf = scattered->delta
                    ? 0.0F
                    : scene.lights.pdf_direction<E>(picked->light, settings.environment, receiver, scattered->wi, time);
    scattered->weight *= scattered->delta ? 2.0F : 2 * mis_weight(Heuristic::balance, scattered->pdf, light_pdf);
  }
  vertex.scattered = scattered;
  vertex.mixed = {from_light ? OneSampleMis::kNoLight : OneSampleMis::kEvery, scattered->pdf + light_pdf};
  return vertex;
}

/// Out of line, and given copies: inlined, what others do not use cost them 4 %, and by reference it held their values
/// in memory, at 6 %.
template <Effects E, Observer O>
[[nodiscard, gnu::noinline]] OneSampleVertex sample_one_direction(const Scene& scene, const Settings& settings,
                                                                  Interaction it, Scatterer bsdf, MediumStack<E> media,
                                                                  Sampler sampler, std::uint32_t bounce, int depth,
                                                                  VertexNumbers u, float time,
                                                                  O& observer) noexcept(!O::allocates) {
  if (settings.technique == Technique::mixture)
    return mixture_vertex<E>(scene, settings, it, bsdf, media, sampler, bounce, depth, u, time, observer);
  return {direct_light<E>(scene, settings, it, bsdf, media, sampler, bounce, depth, u.light_point, time, observer),
          sample_uniform<E>(it, bsdf, sampler, bounce, u.bsdf_direction)};
}

}  // namespace equaltime
