#include "equaltime/render/renderer.h"

#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "equaltime/base/effects.h"
#include "equaltime/base/threads.h"
#include "equaltime/scene/derive_effects.h"

namespace equaltime {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPollInterval{50};
constexpr double kMostSeconds = 1e9;  // a clock holds nine times that; whoever asks for more never waits so long
/// A pass adds at most so many samples to a pixel, so that a block is short and a stop is prompt.
constexpr std::uint64_t kPassSamples = 16;
/// But a small film takes more, up to so many paths in all: starting thousands of passes takes longer than they do.
constexpr std::uint64_t kPassPaths = 4096;

/// A copy of a block of the film and of its ray counts, to be put back where a path is given up or an exception ends
/// the block.
class BlockBefore {
 public:
  void keep(const PixelBlock& block, Film& film, SecondNets& second, const std::uint64_t* rays) {
    moments_.clear(), rays_.clear();
    const std::size_t pixels = std::size_t{block.x1 - block.x0} * (block.y1 - block.y0);
    moments_.reserve(2 * pixels * film.replicates());
    if (rays) rays_.reserve(pixels);
    each(block, film, second, [&](PixelMoments& moments) { moments_.push_back(moments); });
    for (std::uint32_t y = block.y0; rays && y < block.y1; ++y)
      rays_.insert(rays_.end(), rays + row(film, y) + block.x0, rays + row(film, y) + block.x1);
  }
  void put_back(const PixelBlock& block, Film& film, SecondNets& second, std::uint64_t* rays) const {
    if (moments_.empty()) return;  // `keep` found no memory: nothing was changed
    auto moments = moments_.begin();
    each(block, film, second, [&](PixelMoments& now) { now = *moments++; });
    auto before = rays_.begin();
    for (std::uint32_t y = block.y0; rays && y < block.y1; ++y, before += block.x1 - block.x0)
      std::copy_n(before, block.x1 - block.x0, rays + row(film, y) + block.x0);
  }

 private:
  static std::size_t row(const Film& film, std::uint32_t y) noexcept { return std::size_t{y} * film.width(); }
  template <class Visit>
  static void each(const PixelBlock& block, Film& film, SecondNets& second, Visit&& visit) {
    for (std::uint32_t r = 0; r < film.replicates(); ++r)
      for (std::uint32_t y = block.y0; y < block.y1; ++y)
        for (std::uint32_t x = block.x0; x < block.x1; ++x) {
          visit(film.at(r, x, y));
          if (second.has(x, y)) visit(second.at(r, x, y));
        }
  }

  std::vector<PixelMoments> moments_;
  std::vector<std::uint64_t> rays_;
};

/// What a strategy calls for, whatever the scene.
Effects effects_of(const Settings& settings) noexcept { return {.forks = settings.roulette == Roulette::efficiency}; }

/// Replicates are nets of their own, or the halves of one.
Sharing sharing(const RenderOptions& options) noexcept {
  return options.nets == 1 && options.replicates > 1 ? Sharing::halves : Sharing::alternate;
}

/// Counts who is at work, for as long as it lives: also if that ends with an exception, which others must not wait for.
class Present {
 public:
  explicit Present(std::atomic<unsigned>& count) noexcept : count_(count) { ++count_; }
  ~Present() { --count_; }
  Present(const Present&) = delete;
  Present& operator=(const Present&) = delete;

 private:
  std::atomic<unsigned>& count_;
};

Effects both(Effects a, const Effects& b) noexcept {
  for (const auto& [value, name] : kEffectFields) a.*value = a.*value || b.*value;
  return a;
}

}  // namespace

/// One worker's counters, logs and block copy during a pass.
struct Renderer::Worker {
  RayCounter counter;
  BlockBefore before;
  SampleLog<NonFinite> nonfinite;
  SampleLog<FaultySample> faulty;
};

/// When to stop between blocks: shared by the workers of one call of `advance`.
struct Renderer::Stop {
  Stop(std::optional<double> seconds, const std::function<bool()>& p, std::optional<double> pause_seconds,
       std::stop_token token = {})
      : poll(p), cancel(std::move(token)), deadline(in(seconds)), pause(in(pause_seconds)) {}

  const std::function<bool()>& poll;
  const std::stop_token cancel;
  std::optional<Clock::time_point> deadline, pause;
  std::thread::id caller = std::this_thread::get_id();
  Clock::time_point last_poll = Clock::now();
  std::atomic<bool> requested{false};
  std::exception_ptr error;

  /// Called by every worker before it takes a block; polls on the calling thread only.
  bool now() noexcept {
    if (requested.load(std::memory_order_relaxed)) return true;
    if (cancel.stop_requested()) requested = true;
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

  /// Whether a worker that has finished a block takes no other; paths that are on their way go on.
  [[nodiscard]] bool pauses() const noexcept { return pause && Clock::now() >= *pause; }

  /// Lets the calling thread go on polling where a pause left it nothing to do but to wait for the paths of others.
  void wait_for(const std::atomic<unsigned>& others) noexcept {
    if (std::this_thread::get_id() != caller) return;
    while (others > 0 && pauses() && !now()) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }

 private:
  static std::optional<Clock::time_point> in(std::optional<double> seconds) {
    if (!seconds || !(*seconds < kMostSeconds)) return {};
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  }
};

Renderer::Renderer(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options)
    : scene_(std::move(scene)),
      settings_(settings),
      options_(options),
      threads_(options.threads > 0 ? options.threads : static_cast<unsigned>(tbb::info::default_concurrency())),
      need_(both(derive_effects(*scene_), options.also)),
      kernel_(&choose_kernel(both(need_, effects_of(settings)))),
      film_(scene_->film.crop_width, scene_->film.crop_height, std::max(1U, options.replicates), sharing(options)),
      blocks_(blocks()) {
  if (options.nets != 1 && options.nets != film_.replicates())
    throw std::invalid_argument("one net, or as many as replicates");
  if (options.second_net > 0) {
    if (options.nets != 1) throw std::invalid_argument("a second net stands beside one");
    second_ = SecondNets(options.seed, film_.width(), film_.height(), options.second_net);
  }
  scene_->lights.prepare(settings_.lights, settings_.environment);
  if (options.pixel_rays) pixel_rays_.resize(std::size_t{film_.width()} * film_.height());
}

std::vector<PixelBlock> Renderer::blocks() const {
  std::vector<PixelBlock> list;
  const std::uint32_t tile = std::max(1U, options_.tile), w = film_.width(), h = film_.height();
  for (std::uint32_t y = 0; y < h; y += tile)
    for (std::uint32_t x = 0; x < w; x += tile) list.push_back({x, y, std::min(x + tile, w), std::min(y + tile, h)});
  return list;
}

bool Renderer::advance(std::uint64_t samples, std::optional<double> seconds, const std::function<bool()>& poll,
                       std::optional<double> pause) {
  Stop stop(seconds, poll, pause);
  return bring_to(samples, stop);
}

bool Renderer::advance(std::uint64_t samples, std::stop_token cancel, std::optional<double> seconds) {
  const std::function<bool()> no_poll;
  Stop stop(seconds, no_poll, {}, std::move(cancel));
  return bring_to(samples, stop);
}

bool Renderer::bring_to(std::uint64_t samples, Stop& stop) {
  (void)this->settings();  // what is learnt is a part of the time
  const std::uint64_t pixels = std::uint64_t{film_.width()} * film_.height();
  const std::uint64_t pass = std::max(kPassSamples, kPassPaths / std::max<std::uint64_t>(pixels, 1));
  while (at_.done < samples) {
    if (at_.target <= at_.done) at_.target = std::min(samples, at_.done + pass);
    run_pass(stop);
    const bool complete = at_.next_block == blocks_.size() && again_.empty();
    if (complete) {
      at_.done = at_.target;
      at_.next_block = 0;
    }
    const bool stopped = stop.now() || stop.pauses();
    if (stop.error) std::rethrow_exception(stop.error);
    if (!complete || (stopped && at_.done < samples)) return false;
  }
  return true;
}

const Settings& Renderer::settings() {
  if (decision_ || !is_undecided(settings_)) return settings_;
  decision_ = decide_roulette(*scene_, settings_, threads_);
  settings_ = decision_->applied(settings_);
  kernel_ = &choose_kernel(both(need_, effects_of(settings_)));
  if (!taken_up_) {  // or an earlier render has counted them
    counters_.rays += decision_->rays;
    counters_.shadow_rays += decision_->shadow_rays;
  }
  return settings_;
}

bool Renderer::has_samples(const PixelBlock& block, std::uint64_t average) const noexcept {
  for (std::uint32_t y = block.y0; y < block.y1; ++y)
    for (std::uint32_t x = block.x0; x < block.x1; ++x) {
      const std::uint64_t samples = schedule_.count(std::size_t{y} * film_.width() + x, average);
      for (std::uint32_t r = 0; r < film_.replicates(); ++r) {
        const std::uint64_t count = film_.count_of(r, samples);
        if (film_.at(r, x, y).count != count) return false;
        if (second_.has(x, y) && second_.at(r, x, y).count != count) return false;
      }
    }
  return true;
}

void Renderer::adapt(std::uint64_t pilot, std::vector<float> rates) {
  if (rates.size() != std::size_t{film_.width()} * film_.height()) throw std::invalid_argument("a rate for each pixel");
  if (at_.done != 0 && (at_.done != pilot || at_.next_block != 0))
    throw std::invalid_argument("the pixels do not have the pilot's samples");
  schedule_ = SampleSchedule(pilot, std::move(rates), film_.replicates());
}

void Renderer::limit_to(const PixelBlock& window) {
  const auto area = [](const PixelBlock& b) { return std::uint64_t{b.x1 - b.x0} * (b.y1 - b.y0); };
  std::vector<PixelBlock> inside;
  std::uint64_t pixels = 0;
  for (const PixelBlock& b : blocks()) {
    if (b.x0 < window.x0 || b.y0 < window.y0 || b.x1 > window.x1 || b.y1 > window.y1) continue;
    inside.push_back(b);
    pixels += area(b);
  }
  if (window.x0 >= window.x1 || window.y0 >= window.y1 || pixels != area(window))
    throw std::invalid_argument("the window does not consist of whole blocks of the film");
  blocks_ = std::move(inside);
  schedule_ = {};
  at_ = {};
  again_.clear();
  counters_ = {};
  nonfinite_ = {};
  faulty_ = {};
  std::fill(pixel_rays_.begin(), pixel_rays_.end(), 0);
}

void Renderer::take_up(const Counters& so_far, const Position& position) {
  std::vector<std::size_t> again;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (i < position.next_block && has_samples(blocks_[i], position.target)) continue;
    if (!has_samples(blocks_[i], position.done))
      throw std::invalid_argument("the pixels have other sample counts than its passes leave");
    if (i < position.next_block) again.push_back(i);
  }
  again_ = std::move(again);
  at_ = position;
  counters_ = so_far;
  taken_up_ = true;
}

bool Renderer::add_samples(const BlockTask& task, Worker& worker) {
  std::uint64_t* rays = task.pixel_rays;
  const Counters counters = worker.counter.counters;
  const std::size_t logged = worker.nonfinite.size(), faults_logged = worker.faulty.size();
  const auto undo = [&]() noexcept {
    worker.before.put_back(task.block, film_, second_, rays);
    worker.counter.counters = counters;
    worker.nonfinite.shrink(logged);
    worker.faulty.shrink(faults_logged);
  };
  try {
    worker.before.keep(task.block, film_, second_, rays);
    if (options_.traps == Traps::ignore)
      kernel_->render(task, film_, worker.counter, worker.nonfinite);
    else
      render_checked(task, options_.traps, film_, worker.counter, worker.nonfinite, worker.faulty);
  } catch (...) {
    undo();
    throw;
  }
  if (worker.counter.gave_up) undo();
  return !worker.counter.gave_up;
}

void Renderer::run_pass(Stop& stop) {
  std::vector<std::size_t> unfinished;
  unfinished.reserve(again_.size() + blocks_.size() - at_.next_block);  // a block that fails must not need memory
  const std::vector<std::size_t> again = std::exchange(again_, std::move(unfinished));
  const std::size_t tasks = again.size() + blocks_.size() - at_.next_block;
  std::atomic<std::size_t> next{0};
  std::atomic<unsigned> at_work{0};
  std::mutex merge;
  std::exception_ptr failure;
  const std::function<bool()> stops = [&stop] { return stop.now(); };
  const auto take_blocks = [&] {
    const Present here(at_work);
    Worker worker;
    worker.counter.stop = &stops;
    for (bool first = true; !stop.now() && (first || !stop.pauses()); first = false) {
      const std::size_t n = next.fetch_add(1, std::memory_order_relaxed);
      if (n >= tasks) break;
      const std::size_t i = n < again.size() ? again[n] : at_.next_block + n - again.size();
      const BlockTask task{*scene_,
                           settings_,
                           options_.seed,
                           blocks_[i],
                           at_.done,
                           at_.target,
                           options_.nets,
                           &schedule_,
                           options_.pixel_rays ? pixel_rays_.data() : nullptr,
                           second_.film().width() > 0 ? &second_ : nullptr};
      std::exception_ptr error;
      try {
        if (add_samples(task, worker)) continue;
      } catch (...) {
        error = std::current_exception();
        stop.requested = true;
      }
      const std::lock_guard lock(merge);
      again_.push_back(i);
      if (error) failure = error;
    }
    const std::lock_guard lock(merge);
    counters_ += worker.counter.counters;
    nonfinite_.add(worker.nonfinite);
    faulty_.add(worker.faulty);
  };
  const auto work = [&](unsigned) {
    take_blocks();
    stop.wait_for(at_work);
  };
  try {
    on_threads(threads_, work);
  } catch (...) {  // of oneTBB, which may find no memory for its tasks; what the workers finished counts all the same
    failure = std::current_exception();
  }
  if (failure && !stop.error) stop.error = failure;
  const std::size_t begun = std::min(next.load(), tasks);
  for (std::size_t n = begun; n < again.size(); ++n) again_.push_back(again[n]);
  std::sort(again_.begin(), again_.end());
  at_.next_block += begun - std::min(begun, again.size());
}

}  // namespace equaltime
