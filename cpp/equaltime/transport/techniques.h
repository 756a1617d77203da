// The techniques that do not look for direct light at every vertex and go on by the BSDF: uniform directions, and
// one-sample MIS (Veach 1997, §9.2.4), which draws one direction either by the BSDF or towards a light, and follows it.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/transport/gather.h"

namespace equaltime {

/// What a vertex sends back by itself, and how the path goes on.
struct TurnedVertex {
  Spectrum direct;
  Optional<Scattering> scattered;
  OneSampleMis mixed{};
};

/// One-sample MIS. A light is picked, whoever's turn it is; the path's throughput is divided by the mean of the BSDF's
/// density and of that light's, so that each pick by itself is unbiased and no other light is asked for its density.
/// Of emitters that the ray then meets, emission_mis_weight says which count, by the density of the one that is met. A
/// light without directions, such as a point, is aimed at as ever, and leaves every turn to the BSDF.
template <Effects E, Observer O>
[[nodiscard]] TurnedVertex mixture_vertex(const Scene& scene, const Settings& settings, const Interaction& it,
                                          Scatterer bsdf, MediumStack<E> media, const Sampler& sampler,
                                          std::uint32_t bounce, int depth, VertexNumbers u, float time,
                                          O& observer) noexcept(!O::allocates) {
  const LightSampleContext receiver = receiver_at<E>(it, bsdf);
  const auto picked = scene.lights.pick(settings.lights, receiver, sampler, bounce);
  tell<event::LightPicked>(observer, picked);
  const bool has_directions = picked && scene.lights.has_directions<E>(picked->light, receiver, time);
  const bool lights_turn = sampler.get_1d(slot(BounceDimension::technique, bounce)) < 0.5F;
  TurnedVertex vertex;
  if (lights_turn && has_directions) {
    const auto light = scene.lights.sample<E>(SampledLight{picked->light, 1}, settings.environment, receiver, sampler,
                                              bounce, u.light_point, time);
    if (!light) return vertex;
    const auto [value, above] = eval_bsdf<E>(it, bsdf, light->wi);
    vertex.mixed = {picked->light, value.pdf + light->pdf};
    const Spectrum weight = value.f * (2 / vertex.mixed.pdf_sum);
    if (!value.f.is_black()) vertex.scattered = Scattering{light->wi, above, weight, value.pdf, false, 1};
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
  vertex.mixed = {lights_turn ? OneSampleMis::kNoLight : OneSampleMis::kEvery, scattered->pdf + light_pdf};
  return vertex;
}

/// Out of line, and given copies: inlined, what others do not use cost them 4 %, and by reference it held their values
/// in memory, at 6 %.
template <Effects E, Observer O>
[[nodiscard, gnu::noinline]] TurnedVertex sample_one_direction(const Scene& scene, const Settings& settings,
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
