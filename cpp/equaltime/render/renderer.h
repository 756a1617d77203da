// Renderer: renders samples into a film, in passes over ordered blocks of pixels, with a fixed set of threads. One
// thread owns a block during a pass. The film never depends on which thread rendered a block, or when. A Renderer has
// one caller at a time: while `advance` runs, no other thread may call it or read its film. Only requesting a stop by
// the token is allowed. Any number of Renderers may share a scene.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/stop.h"
#include "equaltime/render/checked.h"
#include "equaltime/render/splitting.h"
#include "equaltime/transport/kernel.h"

namespace equaltime {

struct RenderOptions {
  std::uint64_t seed = 0;
  unsigned threads = 0;          // 0: as many as the machine has
  std::uint32_t tile = 16;       // pixels along a block's side
  std::uint32_t replicates = 2;  // of the film
  /// Nets of a pixel: independent scramblings of the sampler's point set. Either as many as replicates; or 1, and the
  /// two halves of the net are the replicates.
  std::uint32_t nets = 2;
  std::uint32_t second_net = 0;  // with one net: one of this many pixels has a second net (`SecondNets`); 0: none
  bool pixel_rays = false;       // count the rays of every pixel's samples in the image
  Effects also = {};             // further effects for the kernel to support, to measure what they cost
  Traps traps = Traps::ignore;   // of floating-point faults
};

class Renderer {
 public:
  Renderer(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options);

  /// Brings every pixel to `samples`. Returns whether every pixel has its samples.
  ///
  /// Ends early, between blocks, when `seconds` have passed, or when `poll` returns false or throws; the calling thread
  /// calls it about every 50 ms. Once stopped, a path of 1024 or more bounces is abandoned, and its block is rendered
  /// again later. After `pause` seconds the call ends early too, but not before every worker has finished a block, so
  /// that repeated calls make progress. Exceptions of `poll` and of workers, such as std::bad_alloc, are rethrown. In
  /// each of these cases the next call continues where this one ended; no sample is lost or counted twice.
  bool advance(std::uint64_t samples, std::optional<double> seconds = {}, const Poll& poll = {},
               std::optional<double> pause = {});

  /// The same, but a stop that any thread requests by the token ends the call early too, between blocks. A stop that
  /// was requested before the call renders nothing.
  bool advance(std::uint64_t samples, std::stop_token cancel, std::optional<double> seconds = {});

  /// Progress of the passes. The current pass takes every pixel from `done` to `target` samples. Blocks before
  /// `next_block` have `target` samples, unless they were abandoned.
  struct Position {
    std::uint64_t done = 0, target = 0;
    std::size_t next_block = 0;
  };
  [[nodiscard]] const Position& position() const noexcept { return position_; }

  /// From here on, sample counts given to `advance` are means over the image: beyond `equal` samples, each pixel's own
  /// number grows in proportion to its rate. Call when every pixel has `equal` samples, or before `resume`. Throws
  /// std::invalid_argument if some have others, or for rates that cannot be.
  void set_sample_rates(std::uint64_t equal, std::vector<float> rates);

  /// From here on, only the blocks in a window of the film are rendered, from the start: other processes render the
  /// rest. The film must have no samples there, unless they are put there before `resume`. Counters start again at the
  /// rays of the pilot, if it is rendered. Throws std::invalid_argument if the window does not consist of whole blocks.
  void limit_to(const PixelBlock& window);

  /// Takes up an earlier render whose moments were put into the film. Throws std::invalid_argument if a pixel's count
  /// is not what passes of this renderer leave there. A film that lacks a sample, because it was not finite, has
  /// another count.
  void resume(const Counters& so_far, const Position& position);

  /// Renders the pilot of roulette and splitting, unless it was rendered or none is needed. Returns the settings, with
  /// the roulette and the splitting map that it chose.
  const Settings& decide();
  /// The pilot's decision; null before it is made, or if none was needed.
  [[nodiscard]] const RouletteDecision* decision() const noexcept { return decision_ ? &*decision_ : nullptr; }
  [[nodiscard]] Film& film() noexcept { return film_; }
  [[nodiscard]] SecondNets& second_nets() noexcept { return second_; }
  [[nodiscard]] const Scene& scene() const noexcept { return *scene_; }
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }
  [[nodiscard]] const SampleLog<NonFinite>& nonfinite() const noexcept { return nonfinite_; }
  /// Samples that raised floating-point faults, the first of each worker and pass; none where faults are ignored.
  [[nodiscard]] const SampleLog<FaultySample>& faulty() const noexcept { return faulty_; }
  /// Rays of each pixel since the renderer was made, row-major; empty unless they are counted. Rays of second nets are
  /// left out, so that a pixel costs alike with and without one.
  [[nodiscard]] const std::vector<std::uint64_t>& pixel_rays() const noexcept { return pixel_rays_; }
  [[nodiscard]] const Kernel& kernel() const noexcept { return *kernel_; }
  [[nodiscard]] unsigned threads() const noexcept { return threads_; }
  /// Most samples that a pass adds to a pixel.
  [[nodiscard]] std::uint64_t pass_samples() const noexcept;
  /// All blocks of the film, by number: the order in which they are begun. `limit_to` leaves this list as it is.
  [[nodiscard]] std::vector<PixelBlock> blocks() const;

 private:
  class Worker;
  bool advance_until(std::uint64_t samples, const StopWhen& when);
  /// Renders the pilot if roulette or splitting is undecided. Returns false, and changes nothing, if it was stopped.
  [[nodiscard]] bool run_pilot(Stop& stop);
  /// Counters before the first sample: the rays of the pilot, if it is rendered.
  [[nodiscard]] Counters pilot_counters() const noexcept;
  void run_pass(Stop& stop);
  /// Returns the task of a block in the current pass.
  [[nodiscard]] BlockTask task(std::size_t block) noexcept;
  /// Whether every pixel of the block has what the schedule gives it at this average.
  [[nodiscard]] bool has_samples(const PixelBlock& block, std::uint64_t average) const noexcept;

  std::shared_ptr<const Scene> scene_;
  Settings settings_;
  RenderOptions options_;
  unsigned threads_;
  Effects need_;  // effects of the scene and of RenderOptions
  const Kernel* kernel_;
  std::optional<RouletteDecision> decision_;  // holds what the settings point to, in every copy
  bool resumed_ = false;
  Film film_;
  SecondNets second_;
  std::vector<PixelBlock> blocks_;
  SampleSchedule schedule_;
  std::vector<std::uint64_t> pixel_rays_;
  Position position_;
  Counters counters_;
  SampleLog<NonFinite> nonfinite_;
  SampleLog<FaultySample> faulty_;
  std::vector<std::size_t> abandoned_blocks_;  // blocks before the next whose samples are missing, in ascending order
};

}  // namespace equaltime
