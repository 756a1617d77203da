// What a path gathers: the emitters that its rays meet, and the light of sampled points, each with its weight.
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
  std::uint32_t light = kEvery;  // the one that it was aimed at, or all if the BSDF drew it
  float pdf_sum = 0;             // the BSDF's and the picked light's, added
};

/// How the ray to the current vertex was made: what the MIS weight of an emitter that it meets depends on.
struct PreviousVertex {
  LightSampleContext from{};    // the vertex that it left
  float pdf = 0;                // of the BSDF, per solid angle
  bool specular_bounce = true;  // no other technique can make this ray: camera rays and discrete directions
  OneSampleMis mixed{};         // of `mixture` alone
};

/// The weight of an emitter met by a scattered ray, given the density of light sampling for the same direction.
[[nodiscard]] EQUALTIME_INLINE float emission_mis_weight(const Settings& s, const PreviousVertex& ray,
                                                         std::uint32_t light, float light_pdf) noexcept {
  if (ray.specular_bounce || !aims_at_lights(s.technique)) return 1;
  if (s.technique == Technique::light) return light_pdf > 0 ? 0.0F : 1.0F;
  if (s.technique == Technique::mis) [[likely]]
    return mis_weight(s.heuristic, ray.pdf, light_pdf);
  if (ray.mixed.light != OneSampleMis::kEvery && ray.mixed.light != light) return 0;
  // Half of all rays are the BSDF's, half the lights': of those, the part that picked this one.
  const float pdf_sum = ray.pdf + light_pdf;
  return pdf_sum > 0 ? ray.mixed.pdf_sum / pdf_sum : 0.0F;
}

/// Radiance that the surface itself sends back along the ray. `ray` is passed by value, here and below: a reference
/// would force the whole path state into memory.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum surface_emission(const Scene& scene, const Settings& settings,
                                                         const Interaction& it, PreviousVertex ray, float time,
                                                         O& observer) noexcept(!O::allocates) {
  if (!scene.geometry.emits(it) || !it.front) return {};
  const std::uint32_t light = scene.geometry.light_of(it);
  float light_pdf = 0;
  if (!ray.specular_bounce && aims_at_lights(settings.technique))
    light_pdf = scene.lights.area_pdf<E>(settings.lights, light, ray.from, -it.wo, it.anchor.p, time);
  tell<event::EmitterHit>(observer, light, light_pdf);
  return scene.radiance<E>(it) * emission_mis_weight(settings, ray, light, light_pdf);
}

template <Effects E>
[[nodiscard]] Spectrum environment_emission(const Scene& scene, const Settings& settings, Vec3f direction,
                                            PreviousVertex made) noexcept {
  if constexpr (E.environment) {
    if (!scene.lights.environment()) return {};
    const LightValue value =
        scene.lights.environment_towards(settings.lights, settings.environment, made.from, direction);
    return value.radiance * emission_mis_weight(settings, made, scene.lights.size() - 1, value.pdf);
  }
  return {};
}

/// Light that reaches the vertex, the path's depth-th, straight from a sampled light, scattered towards wo.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light_from(const Scene& scene, const Settings& settings,
                                                          const Interaction& it, Scatterer bsdf, MediumStack<E> media,
                                                          const LightSample& light, int depth, float time,
                                                          O& observer) noexcept(!O::allocates) {
  auto [value, above] = eval_bsdf<E>(it, bsdf, light.wi);
  tell<event::LightSampled>(observer, light, value);
  if (value.f.is_black()) return {};
  const bool shared = settings.technique != Technique::light && !light.delta;
  const float weight = shared ? mis_weight(settings.heuristic, light.pdf, value.pdf) : 1.0F;
  Spectrum radiance = light.radiance;
  if constexpr (E.textures) radiance = E.motion ? scene.radiance_of(light, time) : scene.radiance_of(light);
  Spectrum unoccluded = value.f * radiance * (weight / light.pdf);
  if constexpr (E.masks || E.media) {
    const int crossings = scene.rules.count_null_interfaces ? settings.max_depth - depth - 1 : kUnlimitedDepth;
    const Spectrum transmittance = shadow_transmittance<E>(scene, it, above, media, light, crossings, time, observer);
    tell<event::LightReceived>(observer, weight, transmittance.max_component());
    return transmittance.is_black() ? Spectrum() : unoccluded * transmittance;
  }
  const float visible = visibility<E>(scene.geometry, it, above, light, time, observer);
  tell<event::LightReceived>(observer, weight, visible);
  return visible > 0 ? unoccluded * visible : Spectrum();
}

/// The same from one light, picked and sampled by the strategy.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE Spectrum direct_light(const Scene& scene, const Settings& settings,
                                                     const Interaction& it, Scatterer bsdf, MediumStack<E> media,
                                                     const Sampler& sampler, std::uint32_t bounce, int depth, Point2f u,
                                                     float time, O& observer) noexcept(!O::allocates) {
  // Where only scattered rays look for light, all that they cannot find are point lights.
  const bool aims = aims_at_lights(settings.technique);
  if (!E.point_lights && !aims) return {};
  const LightSampleContext receiver = receiver_at<E>(it, bsdf);
  const auto picked = scene.lights.pick(settings.lights, receiver, sampler, bounce);
  tell<event::LightPicked>(observer, picked);
  if (!picked) return {};
  auto light = scene.lights.sample<E>(*picked, settings.environment, receiver, sampler, bounce, u, time);
  if (!light || (!aims && !light->delta)) return {};
  return direct_light_from<E>(scene, settings, it, bsdf, media, *light, depth, time, observer);
}

}  // namespace equaltime
