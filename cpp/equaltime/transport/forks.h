// Forks: splitting where a path is scattered first, into as many copies as its pixel's are worth (efficiency.h). What
// the camera's ray and the light aimed at from there cost is shared by all copies; each goes on in a direction of its
// own, with an equal share of the throughput, and with numbers that are together those of as many more samples. This
// keeps the copies still to be followed. Of no size, and nothing to do, in kernels whose paths do not fork.
#pragma once

#include <array>
#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/transport/efficiency.h"
#include "equaltime/transport/gather.h"

namespace equaltime {

/// The numbers of a path, which change where it forks.
template <Effects E>
using NumbersOf = std::conditional_t<E.forks, Sampler, const Sampler&>;

/// A path about to leave a vertex: all that it goes on with.
template <Effects E>
struct Departure {
  Ray ray;
  Spectrum beta;
  float radiance_scale;
  Arrival made;
  PathSurroundings<E> within;
  int depth;  // of the vertex that it goes to
  std::uint32_t crossed;
  Sampler sampler;
};

template <Effects E>
class Forks {
 public:
  Forks(const Settings&, std::uint64_t, std::uint64_t) noexcept {}
};

template <Effects E>
requires(E.forks) class Forks<E> {
 public:
  /// Of a path through this pixel of the full film.
  Forks(const Settings& settings, std::uint64_t x, std::uint64_t y) noexcept
      : log2_copies_(settings.efficiency != nullptr ? settings.efficiency->log2_copies(x, y) : 0) {}

  /// Whether the path forks where it is scattered now.
  [[nodiscard]] bool due() const noexcept { return log2_copies_ > 0 && bsdf_ == nullptr; }

  /// Forks: `path` becomes the first copy, still at the vertex, and the others are kept. No roulette ends them here.
  void fork(const Scene& scene, const Interaction& it, const Bsdf& bsdf, std::uint32_t bounce,
            Departure<E>& path) noexcept {
    bsdf_ = &kept_bsdf_.emplace(bsdf);
    const float share = 1 / static_cast<float>(1U << log2_copies_);
    path.beta *= share;
    path.radiance_scale *= share;  // a share is no reason to end a path
    const Sampler whole = path.sampler;
    for (std::uint32_t copy = (1U << log2_copies_) - 1; copy > 0; --copy) {
      path.sampler = whole.copy(copy, log2_copies_);
      if (const auto scattered =
              sample_bsdf<E>(it, bsdf, path.sampler, bounce, path.sampler.vertex(bounce).bsdf_direction))
        keep(scene, it, *scattered, path);
    }
    path.sampler = whole.copy(0, log2_copies_);
  }

  /// Turns to the next copy, all others having gathered so much; false if there is none.
  [[nodiscard]] bool take(const Spectrum& gathered) noexcept {
    if (waiting_ == 0) return false;
    gathered_ = gathered;
    taken_ = &*copies_[--waiting_];
    return true;
  }
  /// The copy that was turned to; null at the camera.
  [[nodiscard]] const Departure<E>* taken() const noexcept { return taken_; }
  [[nodiscard]] const Spectrum& gathered() const noexcept { return gathered_; }
  /// What scattered it.
  [[nodiscard]] const Bsdf& bsdf() const noexcept { return *bsdf_; }

 private:
  void keep(const Scene& scene, const Interaction& it, const Scattering& s, const Departure<E>& path) noexcept {
    Departure<E>& copy = copies_[waiting_++].emplace(path);
    copy.ray = it.spawn(s.wi, s.above);
    copy.beta *= s.weight;
    copy.radiance_scale *= s.radiance_scale;
    copy.made = {receiver_at<E>(it, *bsdf_), s.pdf, s.delta, {}};
    copy.within.leave(scene, it, s.above);
    ++copy.depth;
  }

  std::uint32_t log2_copies_, waiting_ = 0;
  Spectrum gathered_;
  std::optional<Bsdf> kept_bsdf_;
  const Bsdf* bsdf_ = nullptr;  // where the path forked
  const Departure<E>* taken_ = nullptr;
  std::array<std::optional<Departure<E>>, (1U << Efficiency::kMostLog2) - 1> copies_;
};

}  // namespace equaltime
