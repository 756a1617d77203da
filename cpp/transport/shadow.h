// Shadow rays: how much of a light's radiance reaches a vertex. Where surfaces may let light pass, each that is crossed
// takes its share and counts as one vertex of the path, as it would if the path went through it.
#pragma once

#include "scene/lights.h"
#include "transport/effects.h"

namespace equaltime {

/// The part of the light that gets through to the vertex, with at most so many surfaces crossed on the way; `above`
/// tells on which side of the vertex the light is.
template <Effects E, class Probe>
[[nodiscard]] EQUALTIME_INLINE float unblocked(const Scene& scene, const Interaction& vertex, bool above,
                                               const LightSample& light, int crossings, Probe& probe) noexcept {
  const auto towards_light = [&](const Interaction& from, bool side) noexcept {
    return light.infinite ? from.spawn(light.wi, side) : from.spawn_to(light.target, light.distance, side);
  };
  Ray shadow = towards_light(vertex, above);
  if constexpr (!E.masks) return probe.template occluded<E>(scene, shadow) ? 0.0F : 1.0F;
  for (float share = 1;; --crossings) {
    const auto it = probe.template blocker<E>(scene, shadow);
    if (!it) return share;
    const std::uint32_t material = scene.material(*it);
    if (crossings <= 0 || material == kNone) return 0;
    share *= scene.passing(material, *it);
    if (!(share > 0)) return 0;
    shadow = towards_light(*it, false);
  }
}

}  // namespace equaltime
