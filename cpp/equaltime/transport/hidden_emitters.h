// Mitsuba's `hide_emitters`. Camera rays pass through emissive surfaces until the first vertex of their path. The
// environment is black until the path is scattered; holes, null surfaces and thin glass do not count as scattering.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/scene/shading.h"

namespace equaltime {

/// Whether a path has gone straight on so far, and what it does not see while it does.
template <Effects E>
class HiddenEmitters {
 public:
  explicit HiddenEmitters(bool) noexcept {}
  [[nodiscard]] static constexpr bool skips(const Scene&, const Interaction&, int) noexcept { return false; }
  [[nodiscard]] static constexpr bool sees_no_environment(const Scene&) noexcept { return false; }
  static void scatters(Scatterer, bool) noexcept {}
};

template <Effects E>
requires(E.hidden_emitters) class HiddenEmitters<E> {
 public:
  explicit HiddenEmitters(bool so_far) noexcept : so_far_(so_far) {}
  /// Whether the path goes on as if the surface were not there. `depth`: of the vertex that it would be, from 1. Where
  /// crossings are no vertices, thin glass is none either.
  [[nodiscard]] bool skips(const Scene& scene, const Interaction& it, int depth) const noexcept {
    return sees_no_environment(scene) && (depth == 1 || !scene.rules.count_null_interfaces) && scene.geometry.emits(it);
  }
  [[nodiscard]] bool sees_no_environment(const Scene& scene) const noexcept {
    return so_far_ && scene.rules.hides_emitters;
  }
  /// The path leaves a vertex, above its surface or below.
  void scatters(Scatterer bsdf, bool above) noexcept { so_far_ = so_far_ && !above && bsdf.is_thin(); }

 private:
  bool so_far_;
};

}  // namespace equaltime
