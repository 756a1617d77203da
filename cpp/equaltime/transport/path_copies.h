// Path splitting at the first vertex that scatters, into the number of copies of the pixel (splitting_map.h). All
// copies share the camera ray and the light sampled at that vertex. Each copy goes on in a direction of its own, with
// an equal part of the throughput. Together, the copies use the sample points of a larger sample count. Kernels without
// splitting have an empty PathCopies.
#pragma once

#include <array>
#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/transport/path_state.h"
#include "equaltime/transport/splitting_map.h"

namespace equaltime {

/// The copies of a path that are still to be followed.
template <Effects E>
class PathCopies {
 public:
  PathCopies(const Settings&, std::uint64_t, std::uint64_t) noexcept {}
  template <Observer O>
  [[nodiscard]] static constexpr bool pop(PathState<E>&, O&) noexcept {
    return false;
  }
};

template <Effects E>
requires(E.splitting) class PathCopies<E> {
 public:
  /// No copies yet of a path through pixel (x, y) of the full film.
  PathCopies(const Settings& settings, std::uint64_t x, std::uint64_t y) noexcept
      : log2_copies_(settings.splitting_map != nullptr ? settings.splitting_map->log2_copies(x, y) : 0) {}

  /// Whether to split the path at the current vertex.
  [[nodiscard]] bool due() const noexcept { return log2_copies_ > 0 && !split_; }

  /// Splits: `path` becomes the first copy, still at the vertex, and the others are kept. No roulette ends them here.
  void split(const Scene& scene, const Interaction& it, Scatterer scatterer, PathState<E>& path) noexcept {
    split_ = true;
    if (scatterer.bsdf != nullptr) own_.emplace(*scatterer.bsdf);
    scatterer_ = scatterer.bsdf != nullptr ? Scatterer(*own_) : scatterer;
    const std::uint32_t bounce = path.bounce();
    const float fraction = 1 / static_cast<float>(1U << log2_copies_);
    path.beta *= fraction;
    path.hidden_from_roulette *= fraction;
    const Sampler whole = path.sampler;
    for (std::uint32_t copy = (1U << log2_copies_) - 1; copy > 0; --copy) {
      path.sampler = whole.copy(copy, log2_copies_);
      if (const auto scattered =
              sample_bsdf<E, false>(it, scatterer, path.sampler, bounce, path.sampler.vertex(bounce).bsdf_direction))
        keep(scene, it, *scattered, path);
    }
    path.sampler = whole.copy(0, log2_copies_);
  }

  /// Puts the next copy into `path`, which keeps what it has gathered; false if there is none.
  template <Observer O>
  [[nodiscard]] bool pop(PathState<E>& path, O& observer) noexcept(!O::allocates) {
    if (waiting_ == 0) return false;
    const Spectrum gathered = path.L;
    path = *copies_[--waiting_];
    path.L = gathered;
    tell<event::CopyResumed>(observer, scatterer_);
    return true;
  }

 private:
  void keep(const Scene& scene, const Interaction& it, const ScatterSample& s, const PathState<E>& path) noexcept {
    PathState<E>& copy = copies_[waiting_++].emplace(path);
    copy.apply_weight(s);
    copy.leave(scene, it, scatterer_, s);
  }

  std::uint32_t log2_copies_, waiting_ = 0;
  bool split_ = false;
  std::optional<Bsdf> own_;  // copy of the vertex's BSDF, which later copies of the path outlive
  Scatterer scatterer_;      // of the vertex at which the path was split
  std::array<std::optional<PathState<E>>, (1U << SplittingMap::kMostLog2) - 1> copies_;
};

}  // namespace equaltime
