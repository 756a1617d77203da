// PathState: a path between two rays. Plain data: splitting copies it.
#pragma once

#include <cstdint>
#include <type_traits>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/gather.h"
#include "equaltime/transport/hidden_emitters.h"

namespace equaltime {

/// A path's sampler: a value if paths may be split, because each copy has a sampler of its own, and else a reference.
template <Effects E>
using NumbersOf = std::conditional_t<E.splitting, Sampler, const Sampler&>;

template <Effects E>
struct PathState {
  Ray ray;     // to be traced next
  float time;  // of the whole path, in [0, 1]; 0 if nothing moves
  NumbersOf<E> sampler;
  PathMediumState<E> media;                 // the media and dielectrics that hold the ray
  HiddenEmitters<E> hidden_emitters{true};  // true: nothing has scattered the path yet
  Spectrum L{}, beta{1};                    // radiance gathered; throughput
  float hidden_from_roulette = 1;  // factors of beta that roulette does not see: 1/eta² of refraction, 1/n of splitting
  PreviousVertex previous{};
  int depth = 1;              // of the vertex that the ray goes to, as max_depth counts them
  std::uint32_t crossed = 0;  // surfaces crossed so far that do not count

  /// Index of the ray, and of the random numbers at its end.
  [[nodiscard]] std::uint32_t bounce() const noexcept { return static_cast<std::uint32_t>(depth - 1) + crossed; }

  /// Whether the vertex that the ray goes to is the last one that counts: its light is added, and the path ends.
  [[nodiscard]] EQUALTIME_INLINE bool at_max_depth(const Settings& settings) const noexcept {
    return depth >= settings.max_depth;
  }
  /// Takes back that the vertex counts for max_depth, since the path crossed the surface. `bounce` stays as it is.
  EQUALTIME_INLINE void count_as_crossed() noexcept {
    --depth;
    ++crossed;
  }
  /// Multiplies the throughput by the weight of a sampled direction.
  EQUALTIME_INLINE void apply_weight(const ScatterSample& s) noexcept {
    beta *= s.weight;
    hidden_from_roulette *= s.eta_scale;
  }
  /// Leaves a vertex in a scattered direction.
  EQUALTIME_INLINE void leave(const Scene& scene, const Interaction& it, Scatterer scatterer,
                              const ScatterSample& s) noexcept {
    previous.from = receiver_at<E>(it, scatterer);
    previous.pdf = s.pdf, previous.specular_bounce = s.delta;
    ray = it.spawn(s.wi, s.above);
    media.leave(scene, it, s.above);
    hidden_emitters.scatters(scatterer, s.above);
    ++depth;
  }
  /// Goes straight on through a surface. `counts`: the surface is a vertex for max_depth.
  EQUALTIME_INLINE void cross(const Scene& scene, const Interaction& it, bool counts) noexcept {
    ray = it.spawn(-it.wo, false);
    media.leave(scene, it, false);
    if (counts)
      ++depth;
    else
      ++crossed;
  }
};

/// The scatterer at the end of a ray.
struct Vertex {
  Scatterer scatterer;
  std::uint32_t material = kNone;  // kNone in a medium
  bool may_cross = false;          // thin glass that counts as a vertex only if it reflects
};

}  // namespace equaltime
