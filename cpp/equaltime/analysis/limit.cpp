#include "equaltime/analysis/limit.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>

#include "equaltime/base/run_blocks.h"

namespace equaltime {

namespace {

using Clock = std::chrono::steady_clock;

[[nodiscard]] double seconds_since(Clock::time_point start) noexcept {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A run of blocks and the rays of each, of one pass.
struct Recording {
  std::size_t begin = 0, end = 0;
  std::vector<std::vector<RecordedRay>> rays;  // one a block
};

class LimitRun {
 public:
  LimitRun(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& render,
           const LimitOptions& options, const Poll& poll)
      : scene_(scene),
        seed_(render.seed),
        nets_(render.nets),
        options_(options),
        poll_(poll),
        renderer_(std::move(scene), settings, render),
        blocks_(renderer_.blocks()) {
    renderer_.decide();  // the pilot, if any, is not timed
  }

  /// Samples [first, last) of every pixel, rendered and replayed.
  LimitPair pair(std::uint64_t first, std::uint64_t last, bool replay_first) {
    LimitPair result;
    if (replay_first) replay(first, last, result);
    render(last, result);
    if (!replay_first) replay(first, last, result);
    if (replayed_ != result.counters.rays + result.counters.shadow_rays)
      throw std::logic_error("the recorded rays are not those of the render");
    replayed_ = 0;
    return result;
  }

  [[nodiscard]] const Renderer& renderer() const noexcept { return renderer_; }

 private:
  void render(std::uint64_t last, LimitPair& result) {
    const Counters before = renderer_.counters();
    const Clock::time_point start = Clock::now();
    if (!renderer_.advance(last, {}, poll_)) throw std::runtime_error("cancelled");
    result.render_seconds = seconds_since(start);
    const Counters& after = renderer_.counters();
    result.counters = {after.paths - before.paths, after.rays - before.rays, after.shadow_rays - before.shadow_rays,
                       after.nonfinite - before.nonfinite};
  }

  /// In the renderer's passes: all samples that one adds to a block come before the next block.
  void replay(std::uint64_t first, std::uint64_t last, LimitPair& result) {
    const std::uint64_t pass = renderer_.pass_samples();
    for (std::uint64_t done = first; done < last; done += pass)
      for (std::size_t block = 0; block < blocks_.size();) {
        const Recording part = record(block, done, std::min(done + pass, last));
        const Clock::time_point start = Clock::now();
        result.found += trace(part);
        result.replay_seconds += seconds_since(start);
        block = part.end;
      }
  }

  /// The rays of as many blocks, from `begin` on, as fit into memory; one at least.
  Recording record(std::size_t begin, std::uint64_t first, std::uint64_t last) {
    Recording recording{begin, begin, std::vector<std::vector<RecordedRay>>(blocks_.size() - begin)};
    std::atomic<std::size_t> kept{0};
    Stop stop({.poll = poll_});
    const Settings& settings = renderer_.decide();
    const auto work = [&](std::size_t i) {
      RayRecorder recorder;
      const PixelBlock& block = blocks_[begin + i];
      renderer_.kernel().record({*scene_, settings, seed_, block, first, last, nets_}, recorder);
      recording.rays[i].assign(recorder.rays.begin(), recorder.rays.end());  // no spare capacity
      if ((kept += recorder.rays.size() * sizeof(RecordedRay)) >= options_.memory_bytes) stop.request();
    };
    recording.end += run_blocks(recording.rays.size(), renderer_.threads(), stop, [&] { return work; });
    stop.rethrow();
    return recording;
  }

  /// Sends the rays to Embree and to nothing else; returns how many met something, so that no query is idle.
  std::uint64_t trace(const Recording& part) {
    const Accel& accel = scene_->geometry.accel;
    std::atomic<std::uint64_t> found{0}, traced{0};
    const auto work = [&](std::size_t i) {
      const std::vector<RecordedRay>& rays = part.rays[i];
      std::uint64_t met = 0;
      for (const RecordedRay& r : rays)
        met += r.shadow ? accel.occluded(r.ray, r.time) : accel.closest(r.ray, r.time).has_value();
      found += met;
      traced += rays.size();
    };
    run_blocks(
        part.end - part.begin, renderer_.threads(), [&] { return work; }, poll_);
    replayed_ += traced;
    return found;
  }

  std::shared_ptr<const Scene> scene_;
  std::uint64_t seed_;
  std::uint32_t nets_;
  LimitOptions options_;
  const Poll& poll_;
  Renderer renderer_;
  std::vector<PixelBlock> blocks_;
  std::uint64_t replayed_ = 0;
};

}  // namespace

Limit measure_limit(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& render,
                    const LimitOptions& options, const Poll& poll) {
  LimitRun run(std::move(scene), settings, render, options, poll);
  Limit limit{{}, run.renderer().threads(), run.renderer().kernel().effects};
  for (std::uint32_t i = 0; i < options.pairs; ++i)
    limit.pairs.push_back(
        run.pair(i * options.samples, (i + 1) * options.samples, options.replay_first != (i % 2 == 1)));
  return limit;
}

}  // namespace equaltime
