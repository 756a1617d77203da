// Shadow rays: visibility, and transmittance through null surfaces and thin glass. Each crossing attenuates the light
// and, where null surfaces count, is one vertex of the path, as it is for a path that goes through the surface.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/scene/lights.h"
#include "equaltime/scene/scene.h"
#include "equaltime/scene/shading.h"
#include "equaltime/transport/observer.h"

namespace equaltime {

/// The ray from a side of a surface towards a sampled light.
[[nodiscard]] EQUALTIME_INLINE Ray shadow_ray(const Interaction& from, bool above,
                                              const LightSample<float>& light) noexcept {
  return light.infinite ? from.spawn(light.wi, above) : from.spawn_to(light.target, light.distance, above);
}

/// 1 if the light reaches the vertex, 0 if not. `above`: the light is on the side of the geometric normal.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE float visibility(const SceneGeometry& geometry, const Interaction& vertex, bool above,
                                                const LightSample<float>& light, float time,
                                                O& observer) noexcept(!O::allocates) {
  return occluded<E>(geometry, shadow_ray(vertex, above, light), time, observer) ? 0.0F : 1.0F;
}

/// Whether a shadow ray to this light may cross thin glass. Only delta lights qualify: scattered rays already find all
/// other lights through the glass. If crossings count as vertices, thin glass blocks, as other glass does.
[[nodiscard]] inline bool shines_through_glass(const Scene& scene, const LightSample<float>& light) noexcept {
  return light.delta && !scene.rules.count_null_interfaces;
}

/// Transmittance straight through a material at the point, per channel.
template <Effects E>
[[nodiscard]] Spectrum surface_transmittance(const Scene& scene, std::uint32_t index, const Interaction& it,
                                             bool glass_passes, float time) noexcept {
  const Material& material = scene.appearance.materials[index];
  if (!material.passes) return {};
  if (material.kind == Material::Kind::null) return Spectrum(1);
  if (material.kind == Material::Kind::mixture) {
    const auto part = [&](int i) noexcept {
      return surface_transmittance<E>(scene, material.parts[i], it, glass_passes, time);
    };
    const float w = material.weight_at(scene.appearance.textures, scene.geometry.texture_coords(it));
    return (1 - w) * part(0) + w * part(1);
  }
  if (!glass_passes) return {};
  Interaction perturbed = it;
  perturbed.wo = normalize(it.wo);  // the direction of a shadow ray is not unit
  std::optional<Bsdf> own;
  scene.tilt_frame<E>(index, perturbed, time);
  const Bsdf& bsdf = scene.bsdf<E>(index, perturbed, own);
  return straight_through<E>(perturbed, bsdf);
}

}  // namespace equaltime
