// Probes: what stands between the estimator and the scene's ray queries. RayCounter counts; RayRecorder also keeps the
// rays, so that Embree alone can be timed on the very same ones; SplitProbe (split.h) adds up where light comes from.
#pragma once

#include <functional>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/film/counters.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

/// A path of so many segments, or of a multiple, asks its probe whether to go on.
inline constexpr std::uint32_t kLongPath = 1024;

class RayCounter {
 public:
  static constexpr bool listens = false;    // to events (transport/events.h): then it has a `note` for each
  static constexpr bool allocates = false;  // memory while it counts: the estimator may throw std::bad_alloc

  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE MeetingOf<E> intersect(const Scene& scene, const Ray& ray) noexcept {
    ++counters.rays;
    return scene.intersect<E>(ray, time);
  }
  template <Effects E>
  [[nodiscard]] bool occluded(const Scene& scene, const Ray& ray) noexcept {
    ++counters.shadow_rays;
    return scene.occluded<E>(ray, time);
  }

  /// The nearest surface that a shadow ray meets, where surfaces may let it pass.
  template <Effects E>
  [[nodiscard]] MeetingOf<E> blocker(const Scene& scene, const Ray& ray) noexcept {
    ++counters.shadow_rays;
    return scene.intersect<E>(ray, time);
  }

  /// What follows is told to probes that ask where light comes from: the beginning of a path, with the weight of its
  /// place under the pixel filter; the leaf that scatters it; a light that it aims at; and every contribution to its
  /// radiance, which is given back as it is: from a light that a ray met, and from the one aimed at.
  EQUALTIME_INLINE void begin(float) noexcept { ++counters.paths; }
  static void scatters(const Bsdf&) noexcept {}
  static void aims(const LightSample&) noexcept {}
  EQUALTIME_INLINE static Spectrum met(Spectrum L, std::uint32_t, int) noexcept { return L; }
  EQUALTIME_INLINE static Spectrum lit(Spectrum L, int) noexcept { return L; }

  /// Whether a long path is to be given up, because the render ends: what has come of it counts for nothing then.
  [[gnu::noinline]] bool gives_up() noexcept {
    gave_up = gave_up || (stop && (*stop)());
    return gave_up;
  }

  float time = 0;  // of the path, from 0 to 1, where anything moves
  Counters counters;
  const std::function<bool()>* stop = nullptr;  // whether the render is to end; throws nothing
  bool gave_up = false;
};

struct RecordedRay {
  Ray ray;
  bool shadow;
  float time;
};

class RayRecorder {
 public:
  static constexpr bool listens = false;
  static constexpr bool allocates = true;

  template <Effects E>
  [[nodiscard]] MeetingOf<E> intersect(const Scene& scene, const Ray& ray) {
    rays.push_back({ray, false, time});
    return scene.intersect<E>(ray, time);
  }
  template <Effects E>
  [[nodiscard]] bool occluded(const Scene& scene, const Ray& ray) {
    rays.push_back({ray, true, time});
    return scene.occluded<E>(ray, time);
  }
  template <Effects E>
  [[nodiscard]] MeetingOf<E> blocker(const Scene& scene, const Ray& ray) {
    return intersect<E>(scene, ray);
  }
  EQUALTIME_INLINE void begin(float) noexcept { ++counters.paths; }
  static void scatters(const Bsdf&) noexcept {}
  static void aims(const LightSample&) noexcept {}
  EQUALTIME_INLINE static Spectrum met(Spectrum L, std::uint32_t, int) noexcept { return L; }
  EQUALTIME_INLINE static Spectrum lit(Spectrum L, int) noexcept { return L; }
  static bool gives_up() noexcept { return false; }

  float time = 0;
  Counters counters;
  std::vector<RecordedRay> rays;
};

}  // namespace equaltime
