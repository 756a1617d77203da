// Probes: what stands between the estimator and the scene's ray queries. RayCounter counts; RayRecorder also keeps the
// rays, so that Embree alone can be timed on the very same ones.
#pragma once

#include <vector>

#include "film/counters.h"
#include "math/optional.h"
#include "scene/scene.h"

namespace equaltime {

class RayCounter {
 public:
  template <auto E>
  [[nodiscard]] EQUALTIME_INLINE Optional<Interaction> intersect(const Scene& scene, const Ray& ray) noexcept {
    ++counters.rays;
    return scene.intersect<E>(ray);
  }
  [[nodiscard]] bool occluded(const Accel& accel, const Ray& ray) noexcept {
    ++counters.shadow_rays;
    return accel.occluded(ray);
  }

  /// The nearest surface that a shadow ray meets, where surfaces may let it pass.
  template <auto E>
  [[nodiscard]] Optional<Interaction> blocker(const Scene& scene, const Ray& ray) noexcept {
    ++counters.shadow_rays;
    return scene.intersect<E>(ray);
  }

  Counters counters;
};

struct RecordedRay {
  Ray ray;
  bool shadow;
};

class RayRecorder {
 public:
  template <auto E>
  [[nodiscard]] Optional<Interaction> intersect(const Scene& scene, const Ray& ray) {
    rays.push_back({ray, false});
    return scene.intersect<E>(ray);
  }
  [[nodiscard]] bool occluded(const Accel& accel, const Ray& ray) {
    rays.push_back({ray, true});
    return accel.occluded(ray);
  }
  template <auto E>
  [[nodiscard]] Optional<Interaction> blocker(const Scene& scene, const Ray& ray) {
    return intersect<E>(scene, ray);
  }

  Counters counters;
  std::vector<RecordedRay> rays;
};

}  // namespace equaltime
