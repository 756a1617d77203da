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
  /// The emitter that the ray may add: the light that it was aimed at; any if the BSDF was chosen; none if a light was
  /// chosen that has no directions, so that the BSDF drew the ray.
  std::uint32_t light = kEvery;
  float pdf_sum = 0;  // the BSDF's and the picked light's, added
};

/// How the ray to the current vertex was sampled. The MIS weight of an emitter that the ray hits depends on it.
struct PreviousVertex {
  LightSampleContext from{};    // the vertex that it left
  float pdf = 0;                // of the BSDF, per solid angle
  bool specular_bounce = true;  // no other technique can make this ray: camera rays and discrete directions
  OneSampleMis mixed{};         // of `mixture` alone
};

/// The weight of `mixture`. A ray's density is the mean of both pdfs, because each technique is chosen with probability
/// 1/2. The throughput was divided by pdf_bsdf + pdf_picked. The weight puts the light that the ray hits in the place
/// of the picked one: (pdf_bsdf + pdf_picked) / (pdf_bsdf + pdf_hit).
[[nodiscard]] EQUALTIME_INLINE float mixture_weight(const PreviousVertex& previous, std::uint32_t light,
                                                    float light_pdf) noexcept {
  if (previous.mixed.light != OneSampleMis::kEvery && previous.mixed.light != light) return 0;
  const float pdf_sum_here = previous.pdf + light_pdf;
  return pdf_sum_here > 0 ? previous.mixed.pdf_sum / pdf_sum_here : 0.0F;
}

/// Whether light samples could have made the ray too, so that its emission is weighted.
[[nodiscard]] EQUALTIME_INLINE bool light_samples_compete(const Settings& s, const PreviousVertex& previous) noexcept {
  return !previous.specular_bounce && aims_at_lights(s.technique);
}

/// MIS weight of emission that a scattered ray hits. `light_pdf`: density of light sampling for the ray's direction.
[[nodiscard]] EQUALTIME_INLINE float emission_mis_weight(const Settings& s, const PreviousVertex& previous,
                                                         std::uint32_t light, float light_pdf) noexcept {
  if (!light_samples_compete(s, previous)) return 1;
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
  if (light_samples_compete(settings, previous))
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
    return value.radiance * emission_mis_weight(settings, previous, scene.lights.environment_index(), value.pdf);
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
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light_from(VertexContext<E> vertex, const LightSample<float>& light,
                                                          O& observer) noexcept(!O::allocates) {
  auto [value, above] = eval_bsdf<E>(vertex.it, vertex.scatterer, light.wi);
  tell<event::LightSampled>(observer, light, value);
  if (value.f_cos.is_black()) return {};
  const bool bsdf_finds_it = vertex.settings.technique != Technique::light && !light.delta;
  const float weight = bsdf_finds_it ? mis_weight(vertex.settings.heuristic, light.pdf, value.pdf) : 1.0F;
  Spectrum radiance = light.radiance;
  if constexpr (E.textures)
    radiance = E.motion ? vertex.scene.radiance_of(light, vertex.time) : vertex.scene.radiance_of(light);
  Spectrum unoccluded = value.f_cos * radiance * (weight / light.pdf);
  if constexpr (E.masks || E.media) {
    const int crossings =
        vertex.scene.rules.count_null_interfaces ? vertex.settings.max_depth - vertex.depth - 1 : kUnlimitedDepth;
    const Spectrum transmittance =
        shadow_transmittance<E>(vertex.scene, vertex.it, above, vertex.media, light, crossings, vertex.time, observer);
    tell<event::LightReceived>(observer, weight, transmittance.max_component());
    return transmittance.is_black() ? Spectrum() : unoccluded * transmittance;
  }
  const float visible = visibility<E>(vertex.scene.geometry, vertex.it, above, light, vertex.time, observer);
  tell<event::LightReceived>(observer, weight, visible);
  return visible > 0 ? unoccluded * visible : Spectrum();
}

/// Estimate of the direct light that the vertex scatters towards wo, by one light that the strategy picks. `u` samples
/// a point on it.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light(VertexContext<E> vertex, Point2f u,
                                                     O& observer) noexcept(!O::allocates) {
  // Techniques that find light by scattered rays alone still sample delta lights, which no scattered ray can hit.
  const bool aims = aims_at_lights(vertex.settings.technique);
  if (!E.point_lights && !aims) return {};
  const Lights& lights = vertex.scene.lights;
  const LightSampleContext receiver = receiver_at<E>(vertex.it, vertex.scatterer);
  const LightQuery query{receiver, vertex.sampler, vertex.bounce, u, vertex.time};
  const auto picked = lights.pick(vertex.settings.light_selection, query);
  tell<event::LightPicked>(observer, picked);
  if (!picked) return {};
  auto light = lights.sample<E>(*picked, vertex.settings.environment_sampling, query);
  if (!light || (!aims && !light->delta)) return {};
  return direct_light_from<E>(vertex, *light, observer);
}

}  // namespace equaltime
