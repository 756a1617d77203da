#include "transport/renderer.h"

#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "transport/threads.h"

namespace equaltime {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPollInterval{50};
/// A pass adds at most so many samples to a pixel, so that a block is short and a stop is prompt.
constexpr std::uint64_t kPassSamples = 16;
/// But a small film takes more, up to so many paths in all: starting thousands of passes takes longer than they do.
constexpr std::uint64_t kPassPaths = 4096;
constexpr std::size_t kLoggedNonFinite = 64;

Effects both(Effects a, const Effects& b) noexcept {
  for (const auto& [value, name] : kEffectFields) a.*value = a.*value || b.*value;
  return a;
}

}  // namespace

/// When to stop between blocks: shared by the workers of one call of `advance`.
struct Renderer::Stop {
  explicit Stop(const std::function<bool()>& p) : poll(p) {}

  const std::function<bool()>& poll;
  std::optional<Clock::time_point> deadline;
  std::thread::id caller = std::this_thread::get_id();
  Clock::time_point last_poll = Clock::now();
  std::atomic<bool> requested{false};
  std::exception_ptr error;

  /// Called by every worker before it takes a block; polls on the calling thread only.
  bool now() noexcept {
    if (requested.load(std::memory_order_relaxed)) return true;
    const Clock::time_point time = Clock::now();
    if (deadline && time >= *deadline) requested = true;
    if (poll && std::this_thread::get_id() == caller && time - last_poll >= kPollInterval) {
      last_poll = time;
      try {
        if (!poll()) requested = true;
      } catch (...) {
        error = std::current_exception();
        requested = true;
      }
    }
    return requested;
  }
};

Renderer::Renderer(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options)
    : scene_(std::move(scene)),
      settings_(settings),
      options_(options),
      threads_(options.threads > 0 ? options.threads : static_cast<unsigned>(tbb::info::default_concurrency())),
      kernel_(choose_kernel(both(derive_effects(*scene_), options.also))),
      film_(scene_->film.crop_width, scene_->film.crop_height, std::max(1U, options.replicates)),
      blocks_(blocks()) {
  scene_->lights.prepare(settings_.lights, settings_.environment);
}

std::vector<PixelBlock> Renderer::blocks() const {
  std::vector<PixelBlock> list;
  const std::uint32_t tile = std::max(1U, options_.tile), w = film_.width(), h = film_.height();
  for (std::uint32_t y = 0; y < h; y += tile)
    for (std::uint32_t x = 0; x < w; x += tile) list.push_back({x, y, std::min(x + tile, w), std::min(y + tile, h)});
  return list;
}

bool Renderer::advance(std::uint64_t samples, std::optional<double> seconds, const std::function<bool()>& poll) {
  Stop stop(poll);
  if (seconds)
    stop.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  const std::uint64_t pixels = std::uint64_t{film_.width()} * film_.height();
  const std::uint64_t pass = std::max(kPassSamples, kPassPaths / std::max<std::uint64_t>(pixels, 1));
  while (done_ < samples) {
    if (target_ <= done_) target_ = std::min(samples, done_ + pass);
    run_pass(stop);
    if (stop.error) std::rethrow_exception(stop.error);
    if (next_block_ < blocks_.size()) return false;
    done_ = target_;
    next_block_ = 0;
    if (stop.now() && done_ < samples) return false;
  }
  return true;
}

std::uint64_t Renderer::samples_of(const PixelBlock& block) const {
  const std::uint32_t replicates = film_.replicates();
  std::uint64_t samples = 0;
  for (std::uint32_t r = 0; r < replicates; ++r) samples += film_.at(r, block.x0, block.y0).count;
  for (std::uint32_t y = block.y0; y < block.y1; ++y)
    for (std::uint32_t x = block.x0; x < block.x1; ++x)
      for (std::uint32_t r = 0; r < replicates; ++r)  // sample i belongs to replicate i mod R
        if (film_.at(r, x, y).count != (samples + replicates - 1 - r) / replicates)
          throw std::invalid_argument("the pixels of a block have different sample counts");
  return samples;
}

void Renderer::take_up(const Counters& so_far) {
  std::vector<std::uint64_t> samples;
  samples.reserve(blocks_.size());
  for (const PixelBlock& block : blocks_) samples.push_back(samples_of(block));
  const auto [fewest, most] = std::minmax_element(samples.begin(), samples.end());
  const auto next = std::find(samples.begin(), samples.end(), *fewest);
  const bool ordered = std::all_of(samples.begin(), next, [&](std::uint64_t n) { return n == *most; }) &&
                       std::all_of(next, samples.end(), [&](std::uint64_t n) { return n == *fewest; });
  if (!ordered) throw std::invalid_argument("the blocks were not rendered in order");
  done_ = *fewest;
  target_ = *most;
  next_block_ = static_cast<std::size_t>(next - samples.begin());
  counters_ = so_far;
}

void Renderer::run_pass(Stop& stop) {
  std::atomic<std::size_t> next{next_block_};
  std::mutex merge;
  const auto work = [&](unsigned) {
    RayCounter probe;
    std::vector<NonFinite> nonfinite;
    while (!stop.now()) {
      const std::size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= blocks_.size()) break;
      kernel_.render({*scene_, settings_, options_.seed, blocks_[i], done_, target_}, film_, probe, nonfinite);
    }
    const std::lock_guard lock(merge);
    counters_ += probe.counters;
    for (const NonFinite& n : nonfinite)
      if (nonfinite_.size() < kLoggedNonFinite) nonfinite_.push_back(n);
  };
  on_threads(threads_, work);
  next_block_ = std::min(next.load(), blocks_.size());
}

}  // namespace equaltime
