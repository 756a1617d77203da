#include "equaltime/render/renderer.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/scene/derive_effects.h"

namespace equaltime {

namespace {

/// Most samples that a pass adds to a pixel of a large film: blocks stay short, and a stop is prompt.
constexpr std::uint64_t kPassSamples = 16;
/// Paths of a pass over a small film, which adds more samples to a pixel: starting passes must not dominate the time.
constexpr std::uint64_t kPassPaths = 4096;

/// A copy of a block of the film and its ray counts. It is put back if a path is abandoned or an exception ends the
/// block.
class BlockSnapshot {
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

/// Effects of a strategy, whatever the scene.
Effects effects_of(const Settings& settings) noexcept {
  return {.splitting = settings.roulette == Roulette::efficiency};
}

/// Replicates are nets of their own, or the halves of one.
Sharing sharing(const RenderOptions& options) noexcept {
  return options.nets == 1 && options.replicates > 1 ? Sharing::halves : Sharing::alternate;
}

Effects united(Effects a, const Effects& b) noexcept {
  for (const auto& [value, name] : kEffectFields) a.*value = a.*value || b.*value;
  return a;
}

}  // namespace

Renderer::Renderer(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options)
    : scene_(std::move(scene)),
      settings_(settings),
      options_(options),
      threads_(thread_count(options.threads)),
      need_(united(derive_effects(*scene_), options.also)),
      kernel_(&choose_kernel(united(need_, effects_of(settings)))),
      film_(scene_->camera.film.crop_width, scene_->camera.film.crop_height, std::max(1U, options.replicates),
            sharing(options)),
      blocks_(blocks()) {
  if (options.nets != 1 && options.nets != film_.replicates())
    throw std::invalid_argument("one net, or as many as replicates");
  if (options.second_net > 0) {
    if (options.nets != 1) throw std::invalid_argument("a second net stands beside one");
    second_ = SecondNets(options.seed, film_.width(), film_.height(), options.second_net);
  }
  scene_->lights.prepare(settings_.light_selection, settings_.environment_sampling);
  if (options.pixel_rays) pixel_rays_.resize(std::size_t{film_.width()} * film_.height());
}

std::vector<PixelBlock> Renderer::blocks() const {
  std::vector<PixelBlock> list;
  const std::uint32_t tile = std::max(1U, options_.tile), w = film_.width(), h = film_.height();
  for (std::uint32_t y = 0; y < h; y += tile)
    for (std::uint32_t x = 0; x < w; x += tile) list.push_back({x, y, std::min(x + tile, w), std::min(y + tile, h)});
  return list;
}

bool Renderer::advance(std::uint64_t samples, std::optional<double> seconds, const Poll& poll,
                       std::optional<double> pause) {
  return advance_until(samples, {.poll = poll, .seconds = seconds, .pause = pause});
}

bool Renderer::advance(std::uint64_t samples, std::stop_token cancel, std::optional<double> seconds) {
  return advance_until(samples, {.cancel = std::move(cancel), .seconds = seconds});
}

std::uint64_t Renderer::pass_samples() const noexcept {
  const std::uint64_t pixels = std::uint64_t{film_.width()} * film_.height();
  return std::max(kPassSamples, kPassPaths / std::max<std::uint64_t>(pixels, 1));
}

bool Renderer::advance_until(std::uint64_t samples, const StopWhen& when) {
  Stop stop(when);
  // The time of the pilot counts, but no deadline cuts it: half a pilot decides nothing.
  if (Stop without_deadline({.poll = when.poll, .cancel = when.cancel}); !run_pilot(without_deadline)) {
    without_deadline.rethrow();
    return false;
  }
  while (position_.done < samples) {
    if (position_.target <= position_.done) position_.target = std::min(samples, position_.done + pass_samples());
    run_pass(stop);
    const bool complete = position_.next_block == blocks_.size() && abandoned_blocks_.empty();
    if (complete) {
      position_.done = position_.target;
      position_.next_block = 0;
    }
    const bool stopped = stop.now() || stop.pauses();
    stop.rethrow();
    if (!complete || (stopped && position_.done < samples)) return false;
  }
  return true;
}

const Settings& Renderer::decide() {
  Stop never;
  (void)run_pilot(never);
  never.rethrow();
  return settings_;
}

bool Renderer::run_pilot(Stop& stop) {
  if (decision_ || !is_undecided(settings_)) return true;
  RouletteDecision decision = decide_roulette(*scene_, settings_, threads_, stop);
  if (stop.requested()) return false;
  decision_ = std::move(decision);
  settings_ = decision_->applied(settings_);
  kernel_ = &choose_kernel(united(need_, effects_of(settings_)));
  if (!resumed_) counters_ += pilot_counters();  // or an earlier render has counted them
  return true;
}

Counters Renderer::pilot_counters() const noexcept {
  if (!decision_) return {};
  return {.rays = decision_->rays, .shadow_rays = decision_->shadow_rays};
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

void Renderer::set_sample_rates(std::uint64_t equal, std::vector<float> rates) {
  if (rates.size() != std::size_t{film_.width()} * film_.height()) throw std::invalid_argument("a rate for each pixel");
  if (position_.done != 0 && (position_.done != equal || position_.next_block != 0))
    throw std::invalid_argument("the pixels do not have equal samples");
  schedule_ = SampleSchedule(equal, std::move(rates), film_.replicates());
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
  position_ = {};
  abandoned_blocks_.clear();
  counters_ = pilot_counters();
  resumed_ = false;
  nonfinite_ = {};
  faulty_ = {};
  std::fill(pixel_rays_.begin(), pixel_rays_.end(), 0);
}

void Renderer::resume(const Counters& so_far, const Position& position) {
  std::vector<std::size_t> again;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    if (i < position.next_block && has_samples(blocks_[i], position.target)) continue;
    if (!has_samples(blocks_[i], position.done))
      throw std::invalid_argument("the pixels have other sample counts than its passes leave");
    if (i < position.next_block) again.push_back(i);
  }
  abandoned_blocks_ = std::move(again);
  position_ = position;
  counters_ = so_far;
  resumed_ = true;
}

/// One thread's part of a pass. It renders blocks, and adds its counters and logs to the renderer at the end.
class Renderer::Worker {
 public:
  Worker(Renderer& renderer, Stop& stop, std::mutex& merge) noexcept : renderer_(renderer), merge_(merge) {
    counter_.stop = &stop;
  }
  ~Worker() {
    const std::lock_guard lock(merge_);
    renderer_.counters_ += counter_.counters;
    renderer_.nonfinite_.add(nonfinite_);
    renderer_.faulty_.add(faulty_);
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Renders the pass's samples of a block. If a path is abandoned or an exception is thrown, restores the block, the
  /// counters and the logs, and queues the block again. Rethrows the exception.
  void add_samples(std::size_t block) {
    const BlockTask task = renderer_.task(block);
    const Counters counters = counter_.counters;
    const std::size_t logged = nonfinite_.size(), faults_logged = faulty_.size();
    const auto undo = [&]() noexcept {
      before_.put_back(task.block, renderer_.film_, renderer_.second_, task.pixel_rays);
      counter_.counters = counters;
      nonfinite_.shrink(logged);
      faulty_.shrink(faults_logged);
      const std::lock_guard lock(merge_);
      renderer_.abandoned_blocks_.push_back(block);
    };
    try {
      before_.keep(task.block, renderer_.film_, renderer_.second_, task.pixel_rays);
      render(task);
    } catch (...) {
      undo();
      throw;
    }
    if (counter_.abandoned) undo();
  }

 private:
  void render(const BlockTask& task) {
    if (renderer_.options_.traps == Traps::ignore)
      renderer_.kernel_->render(task, renderer_.film_, counter_, nonfinite_);
    else
      render_checked(task, renderer_.options_.traps, renderer_.film_, counter_, nonfinite_, faulty_);
  }

  Renderer& renderer_;
  std::mutex& merge_;
  RayCounter counter_;
  BlockSnapshot before_;
  SampleLog<NonFinite> nonfinite_;
  SampleLog<FaultySample> faulty_;
};

BlockTask Renderer::task(std::size_t block) noexcept {
  return {*scene_,
          settings_,
          options_.seed,
          blocks_[block],
          position_.done,
          position_.target,
          options_.nets,
          &schedule_,
          options_.pixel_rays ? pixel_rays_.data() : nullptr,
          second_.film().width() > 0 ? &second_ : nullptr};
}

void Renderer::run_pass(Stop& stop) {
  // Workers put the blocks that they abandon into abandoned_blocks_. Its memory is reserved before, because a block may
  // be abandoned for want of memory.
  std::vector<std::size_t> reserved;
  reserved.reserve(abandoned_blocks_.size() + blocks_.size() - position_.next_block);
  const std::vector<std::size_t> again = std::exchange(abandoned_blocks_, std::move(reserved));
  const std::size_t tasks = again.size() + blocks_.size() - position_.next_block;
  std::mutex merge;
  const std::size_t begun = run_blocks(tasks, threads_, stop, [&] {
    return [&, worker = std::make_unique<Worker>(*this, stop, merge)](std::size_t n) {
      worker->add_samples(n < again.size() ? again[n] : position_.next_block + n - again.size());
    };
  });
  for (std::size_t n = begun; n < again.size(); ++n) abandoned_blocks_.push_back(again[n]);
  std::sort(abandoned_blocks_.begin(), abandoned_blocks_.end());
  position_.next_block += begun - std::min(begun, again.size());
}

}  // namespace equaltime
