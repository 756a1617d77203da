// The estimator: one path from the camera, with next-event estimation. Settings choose how samples of lights and of
// BSDFs are combined; the expected radiance is the same for all settings but max_depth, which says which paths count.
// Nothing is clamped. Radiance that is not finite is returned as such; sample_pixel.h leaves it out of the film, and
// logs it.
#pragma once

#include <cstdint>
#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/path_steps.h"

namespace equaltime {

/// Number of bounces after which a path asks its observer whether to go on, again and again.
inline constexpr std::uint32_t kCancelInterval = 1024;

/// Radiance of a path that begins with a camera ray, its copies after splitting included. `time` is in [0, 1].
template <Effects E, Observer O>
[[nodiscard]] Spectrum trace_path(const Scene& scene, const Settings& settings, const Ray& camera_ray, float time,
                                  const Sampler& sampler, PathCopies<E> copies, O& observer) noexcept(!O::allocates) {
  PathState<E> path{camera_ray, time, sampler, PathMediumState<E>(scene, camera_ray, time)};
  std::optional<Bsdf> made;  // BSDF that textures make at the vertex; declared once, because it is large
  for (;;) {
    if (path.bounce() % kCancelInterval == kCancelInterval - 1 && observer.cancelled()) [[unlikely]]
      return path.L;
    const VertexNumbers u = path.sampler.vertex(path.bounce());  // before tracing: the processor does both at once
    const Ray ray = path.ray;                                    // a copy: a reference would force the path into memory
    tell<event::RayTraced>(observer, ray, path.time, path.previous, path.beta, path.L);
    auto hit = closest<E>(scene.geometry, ray, path.time, observer);
    tell<event::RayHit>(observer, ray, hit.it ? &*hit.it : nullptr);
    Vertex v;
    const Arrival arrival = arrive<E>(scene, settings, path, hit, v, made, observer);
    bool goes_on = arrival == Arrival::crosses;
    if (arrival == Arrival::scatters) [[likely]] {
      const Interaction& it = *hit.it;
      tell<event::VertexReached>(observer, v.scatterer);
      const Optional<ScatterSample> scattered = scatter<E>(scene, settings, path, it, v, u, copies, observer);
      tell<event::DirectionSampled>(observer, it, v.material, v.scatterer, scattered);
      goes_on = scattered && !observer.stops_path() && depart<E>(scene, settings, path, it, v, *scattered, observer);
    }
    if (!goes_on && !copies.pop(path, observer)) return path.L;
  }
}

}  // namespace equaltime
