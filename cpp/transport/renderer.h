// Renderer: brings the film to a number of samples, in passes of ordered blocks over a fixed set of threads.
// A worker owns a block, hence its pixels, for a pass; what is in the film never depends on who did it or when.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "transport/kernels.h"

namespace equaltime {

struct RenderOptions {
  std::uint64_t seed = 0;
  unsigned threads = 0;          // 0: as many as the machine has
  std::uint32_t tile = 16;       // pixels along a block's side
  std::uint32_t replicates = 2;  // independent scrambles, for the error bar
  Effects also = {};             // that the kernel must cover, to see what its not doing so is worth
};

class Renderer {
 public:
  Renderer(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options);

  /// Brings every pixel to `samples`. Ends early, between blocks, when `seconds` have passed or `poll` (called about
  /// every 50 ms by the calling thread) returns false or throws, which is thrown on; the next call takes up where this
  /// one ended. Returns whether every pixel has its samples.
  bool advance(std::uint64_t samples, std::optional<double> seconds = {}, const std::function<bool()>& poll = {});

  /// Takes up an earlier render whose moments were put into the film: what is done follows from the pixels' counts.
  /// Throws std::invalid_argument if no passes of this renderer leave such counts.
  void take_up(const Counters& so_far);

  [[nodiscard]] Film& film() noexcept { return film_; }
  [[nodiscard]] const Scene& scene() const noexcept { return *scene_; }
  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }
  [[nodiscard]] const std::vector<NonFinite>& nonfinite() const noexcept { return nonfinite_; }
  [[nodiscard]] const KernelRow& kernel() const noexcept { return kernel_; }
  [[nodiscard]] unsigned threads() const noexcept { return threads_; }
  /// The block of each number, in the order in which they are begun.
  [[nodiscard]] std::vector<PixelBlock> blocks() const;

 private:
  struct Stop;
  void run_pass(Stop& stop);
  [[nodiscard]] std::uint64_t samples_of(const PixelBlock& block) const;

  std::shared_ptr<const Scene> scene_;
  Settings settings_;
  RenderOptions options_;
  unsigned threads_;
  const KernelRow& kernel_;
  Film film_;
  std::vector<PixelBlock> blocks_;
  // Every pixel has `done_` samples; blocks before `next_block_` have `target_`.
  std::uint64_t done_ = 0, target_ = 0;
  std::size_t next_block_ = 0;
  Counters counters_;
  std::vector<NonFinite> nonfinite_;
};

}  // namespace equaltime
