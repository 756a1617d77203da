// Radiance that a path gathers: emission of surfaces and environment that its rays hit, and light of sampled points,
// each with its MIS weight.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/scene/scene.h"
#include "equaltime/scene/shading.h"
#include "equaltime/transport/observer.h"
#include "equaltime/transport/settings.h"
#include "equaltime/transport/shadow.h"
#include "equaltime/transport/volume.h"

namespace equaltime {

/// One-sample MIS of a ray: the lights whose emission it may add, and the sum of pdfs that divided its throughput.
struct OneSampleMis {
  static constexpr std::uint32_t kEvery = ~std::uint32_t{0}, kNoLight = kEvery - 1;
  std::uint32_t light = kEvery;  // the picked light if the ray was aimed at it; all if the choice was the BSDF; none if
                                 // it was a light, but the picked one has no directions
  float pdf_sum = 0;             // the BSDF's and the picked light's, added
};

/// How the ray to the current vertex was sampled. The MIS weight of an emitter that the ray hits depends on it.
struct PreviousVertex {
  LightSampleContext from{};    // the vertex that it left
  float pdf = 0;                // of the BSDF, per solid angle
  bool specular_bounce = true;  // no other technique can make this ray: camera rays and discrete directions
  OneSampleMis mixed{};         // of `mixture` alone
};

/// The weight of `mixture`. A ray's density is the mean of both pdfs, because each technique is chosen with probability
/// 1/2. The throughput was divided by the sum with the picked light's pdf. The sum with the pdf of the light that is
/// met takes its place.
[[nodiscard]] EQUALTIME_INLINE float mixture_weight(const PreviousVertex& previous, std::uint32_t light,
                                                    float light_pdf) noexcept {
  if (previous.mixed.light != OneSampleMis::kEvery && previous.mixed.light != light) return 0;
  const float pdf_sum_here = previous.pdf + light_pdf;
  return pdf_sum_here > 0 ? previous.mixed.pdf_sum / pdf_sum_here : 0.0F;
}

/// MIS weight of emission that a scattered ray hits. `light_pdf`: density of light sampling for the ray's direction.
[[nodiscard]] EQUALTIME_INLINE float emission_mis_weight(const Settings& s, const PreviousVertex& previous,
                                                         std::uint32_t light, float light_pdf) noexcept {
  if (previous.specular_bounce || !aims_at_lights(s.technique)) return 1;
  if (s.technique == Technique::mis) [[likely]]
    return mis_weight(s.heuristic, previous.pdf, light_pdf);
  if (s.technique == Technique::light) return light_pdf > 0 ? 0.0F : 1.0F;
  return mixture_weight(previous, light, light_pdf);
}

/// Radiance that the surface itself sends back along the ray. `previous` is passed by value, here and below: a
/// reference would force the whole path state into memory.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum surface_emission(const Scene& scene, const Settings& settings,
                                                         const Interaction& it, PreviousVertex previous, float time,
                                                         O& observer) noexcept(!O::allocates) {
  if (!scene.geometry.emits(it) || !it.front) return {};
  const std::uint32_t light = scene.geometry.light_of(it);
  float light_pdf = 0;
  if (!previous.specular_bounce && aims_at_lights(settings.technique))
    light_pdf = scene.lights.area_pdf<E>(settings.light_selection, light, previous.from, -it.wo, it.anchor.p, time);
  tell<event::EmitterHit>(observer, light, light_pdf);
  return scene.radiance<E>(it) * emission_mis_weight(settings, previous, light, light_pdf);
}

template <Effects E>
[[nodiscard]] Spectrum environment_emission(const Scene& scene, const Settings& settings, Vec3f direction,
                                            PreviousVertex previous) noexcept {
  if constexpr (E.environment) {
    if (!scene.lights.environment()) return {};
    const LightValue<float> value = scene.lights.environment_towards(
        settings.light_selection, settings.environment_sampling, previous.from, direction);
    return value.radiance * emission_mis_weight(settings, previous, scene.lights.size() - 1, value.pdf);
  }
  return {};
}

/// A vertex while light and directions are sampled there: nothing of it changes meanwhile. Pass it by value: a
/// reference would force the path's state into memory.
template <Effects E>
struct VertexContext {
  const Scene& scene;
  const Settings& settings;
  const Interaction& it;
  Scatterer scatterer;
  MediumState<E> media;
  const Sampler& sampler;
  std::uint32_t bounce;  // index of the vertex's random numbers
  int depth;             // of the vertex, as max_depth counts it
  float time;
};

/// Radiance that the vertex scatters towards wo, of the light of one light sample.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light_from(VertexContext<E> at, const LightSample<float>& light,
                                                          O& observer) noexcept(!O::allocates) {
  auto [value, above] = eval_bsdf<E>(at.it, at.scatterer, light.wi);
  tell<event::LightSampled>(observer, light, value);
  if (value.f_cos.is_black()) return {};
  const bool bsdf_finds_it = at.settings.technique != Technique::light && !light.delta;
  const float weight = bsdf_finds_it ? mis_weight(at.settings.heuristic, light.pdf, value.pdf) : 1.0F;
  Spectrum radiance = light.radiance;
  if constexpr (E.textures) radiance = E.motion ? at.scene.radiance_of(light, at.time) : at.scene.radiance_of(light);
  Spectrum unoccluded = value.f_cos * radiance * (weight / light.pdf);
  if constexpr (E.masks || E.media) {
    const int crossings = at.scene.rules.count_null_interfaces ? at.settings.max_depth - at.depth - 1 : kUnlimitedDepth;
    const Spectrum transmittance =
        shadow_transmittance<E>(at.scene, at.it, above, at.media, light, crossings, at.time, observer);
    tell<event::LightReceived>(observer, weight, transmittance.max_component());
    return transmittance.is_black() ? Spectrum() : unoccluded * transmittance;
  }
  const float visible = visibility<E>(at.scene.geometry, at.it, above, light, at.time, observer);
  tell<event::LightReceived>(observer, weight, visible);
  return visible > 0 ? unoccluded * visible : Spectrum();
}

/// Estimate of the direct light that the vertex scatters towards wo, by one light that the strategy picks. `u` samples
/// a point on it.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light(VertexContext<E> at, Point2f u,
                                                     O& observer) noexcept(!O::allocates) {
  // Techniques that find light by scattered rays alone still sample delta lights, which no scattered ray can hit.
  const bool aims = aims_at_lights(at.settings.technique);
  if (!E.point_lights && !aims) return {};
  const Lights& lights = at.scene.lights;
  const LightSampleContext receiver = receiver_at<E>(at.it, at.scatterer);
  const LightQuery query{receiver, at.sampler, at.bounce, u, at.time};
  const auto picked = lights.pick(at.settings.light_selection, query);
  tell<event::LightPicked>(observer, picked);
  if (!picked) return {};
  auto light = lights.sample<E>(*picked, at.settings.environment_sampling, query);
  if (!light || (!aims && !light->delta)) return {};
  return direct_light_from<E>(at, *light, observer);
}

}  // namespace equaltime
