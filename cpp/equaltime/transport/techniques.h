// The techniques that do not look for direct light at every vertex and go on by the BSDF: uniform directions, and
// one-sample MIS (Veach 1997, §9.2.4), which draws one direction either by the BSDF or towards a light, and follows it.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/transport/gather.h"

namespace equaltime {

/// Direct light of a vertex, and the direction in which the path goes on.
struct OneSampleEstimate {
  Spectrum direct;
  Optional<ScatterSample> scattered;
  OneSampleMis mixed{};
};

/// One-sample MIS of the BSDF and one picked light. The throughput is divided by the mean of both pdfs. Each pick is
/// therefore unbiased by itself, and no other light's pdf is needed. `emission_mis_weight` says which emitters count
/// that the ray then meets. A delta light is sampled as ever, and the BSDF draws every direction.
template <Effects E, Observer O>
[[nodiscard]] OneSampleEstimate mixture_vertex(VertexContext<E> vertex, VertexNumbers u,
                                               O& observer) noexcept(!O::allocates) {
  const Lights& lights = vertex.scene.lights;
  const LightSampleContext receiver = receiver_at<E>(vertex.it, vertex.scatterer);
  const LightQuery query{receiver, vertex.sampler, vertex.bounce, u.light_point, vertex.time};
  const auto picked = lights.pick(vertex.settings.light_selection, query);
  tell<event::LightPicked>(observer, picked);
  const bool has_directions = picked && lights.has_directions<E>(picked->light, receiver, vertex.time);
  const bool from_light = vertex.sampler.get_1d(slot(BounceDecision::technique, vertex.bounce)) < 0.5F;
  OneSampleEstimate estimate;
  if (from_light && has_directions) {
    const auto light = lights.sample<E>(PickedLight{picked->light, 1}, vertex.settings.environment_sampling, query);
    if (!light) return estimate;
    const auto [value, above] = eval_bsdf<E>(vertex.it, vertex.scatterer, light->wi);
    estimate.mixed = {picked->light, value.pdf + light->pdf};
    const Spectrum weight = value.f_cos * (2 / estimate.mixed.pdf_sum);
    if (!value.f_cos.is_black()) estimate.scattered = ScatterSample{light->wi, above, weight, value.pdf, false, 1};
    return estimate;
  }
  if (picked && !has_directions) {
    const auto point = lights.sample<E>(*picked, vertex.settings.environment_sampling, query);
    if (point) estimate.direct = direct_light_from<E>(vertex, *point, observer);
  }
  auto scattered = sample_bsdf<E, false>(vertex.it, vertex.scatterer, vertex.sampler, vertex.bounce, u.bsdf_direction);
  if (!scattered) return estimate;
  float light_pdf = scattered->pdf;  // without a light to aim at, the BSDF draws every direction
  if (has_directions) {
    light_pdf = scattered->delta ? 0.0F
                                 : lights.pdf_direction<E>(picked->light, vertex.settings.environment_sampling,
                                                           receiver, scattered->wi, vertex.time);
    scattered->weight *= scattered->delta ? 2.0F : 2 * mis_weight(Heuristic::balance, scattered->pdf, light_pdf);
  }
  estimate.scattered = scattered;
  estimate.mixed = {from_light ? OneSampleMis::kNoLight : OneSampleMis::kEvery, scattered->pdf + light_pdf};
  return estimate;
}

/// Out of line: inlined, it costs the other techniques 4 %. The context must refer to copies of the interaction and the
/// sampler: references to the path's own would hold them in memory, at 6 %.
template <Effects E, Observer O>
[[nodiscard, gnu::noinline]] OneSampleEstimate sample_one_direction(VertexContext<E> vertex, VertexNumbers u,
                                                                    O& observer) noexcept(!O::allocates) {
  if (vertex.settings.technique == Technique::mixture) return mixture_vertex<E>(vertex, u, observer);
  return {direct_light<E>(vertex, u.light_point, observer),
          sample_uniform<E>(vertex.it, vertex.scatterer, vertex.sampler, vertex.bounce, u.bsdf_direction)};
}

}  // namespace equaltime
