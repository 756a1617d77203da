// Observers watch a path while it is traced. An observer has `on(event)` for every event that it wants. Kernels contain
// no code for other events. An observer changes a path only by the constants of PathObserver.
#pragma once

#include <concepts>
#include <type_traits>
#include <utility>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/floating_point.h"
#include "equaltime/base/stop.h"
#include "equaltime/film/counters.h"
#include "equaltime/scene/scene_geometry.h"
#include "equaltime/transport/events.h"

namespace equaltime {

/// Defaults of an observer.
struct PathObserver {
  static constexpr bool allocates = false;    // its functions may throw std::bad_alloc
  static constexpr bool sees_shadows = true;  // if false, shadow rays are not traced: every light is visible
  using Guard = Unguarded;                    // an object of this class lives while Embree searches
  static constexpr bool stops_path() noexcept { return false; }  // whether the path ends here for it
  static constexpr bool cancelled() noexcept { return false; }   // whether a long path is to be abandoned
};

static_assert(std::is_empty_v<PathObserver>);

template <class T>
concept Observer = std::derived_from<T, PathObserver>;
template <class T, class Event>
concept Observes = requires(T& observer, const Event& event) {
  observer.on(event);
};

/// Tells the observer of an event, if it asks for it.
template <class Event, Observer O, class... Parts>
EQUALTIME_INLINE void tell(O& observer, Parts&&... parts) noexcept(!O::allocates) {
  if constexpr (Observes<O, Event>) observer.on(Event{std::forward<Parts>(parts)...});
}

/// The nearest surface that a ray meets.
template <Effects E, Observer O>
[[nodiscard]] EQUALTIME_INLINE SurfaceIntersection<E> closest(const SceneGeometry& geometry, const Ray& ray, float time,
                                                              O&) noexcept {
  return geometry.closest<E, typename O::Guard>(ray, time);
}

/// Whether anything stands on a shadow ray.
template <Effects E, Observer O>
[[nodiscard]] bool occluded(const SceneGeometry& geometry, const Ray& ray, float time,
                            O& observer) noexcept(!O::allocates) {
  if constexpr (!O::sees_shadows) return false;
  const bool blocked = [&]() noexcept {
    [[maybe_unused]] const typename O::Guard guard;
    return geometry.occluded<E>(ray, time);
  }();
  tell<event::ShadowRayTraced>(observer, ray, time, blocked);
  return blocked;
}

/// The nearest surface on a shadow ray, where surfaces may let it pass.
template <Effects E, Observer O>
[[nodiscard]] SurfaceIntersection<E> closest_occluder(const SceneGeometry& geometry, const Ray& ray, float time,
                                                      O& observer) noexcept(!O::allocates) {
  if constexpr (!O::sees_shadows) return {};
  auto hit = geometry.closest<E, typename O::Guard>(ray, time);
  const Optional<Interaction>& it = hit.it;
  tell<event::ShadowRayHit>(observer, ray, time, it ? &*it : nullptr);
  return hit;
}

/// Counts paths and rays.
class RayCounter : public PathObserver {
 public:
  EQUALTIME_INLINE void on(const event::PathStarted&) noexcept { ++counters.paths; }
  EQUALTIME_INLINE void on(const event::RayTraced&) noexcept { ++counters.rays; }
  EQUALTIME_INLINE void on(const event::ShadowRayTraced&) noexcept { ++counters.shadow_rays; }
  EQUALTIME_INLINE void on(const event::ShadowRayHit&) noexcept { ++counters.shadow_rays; }
  EQUALTIME_INLINE void on(const event::EmitterRayTraced&) noexcept { ++counters.shadow_rays; }

  /// Whether to abandon a long path because the render ends. Its sample is then discarded.
  [[gnu::noinline]] bool cancelled() noexcept {
    abandoned = abandoned || (stop && stop->now());
    return abandoned;
  }

  Counters counters;
  Stop* stop = nullptr;  // of the render
  bool abandoned = false;
};

struct RecordedRay {
  Ray ray;
  bool shadow;
  float time;
};

/// Keeps the rays, so that Embree alone can be timed on the very same ones (analysis/limit.h).
class RayRecorder : public PathObserver {
 public:
  static constexpr bool allocates = true;

  void on(const event::RayTraced& traced) { rays.push_back({traced.ray, false, traced.time}); }
  void on(const event::ShadowRayTraced& traced) { rays.push_back({traced.ray, true, traced.time}); }
  void on(const event::ShadowRayHit& hit) { rays.push_back({hit.ray, false, hit.time}); }
  void on(const event::EmitterRayTraced& traced) { rays.push_back({traced.ray, false, traced.time}); }

  std::vector<RecordedRay> rays;
};

}  // namespace equaltime
