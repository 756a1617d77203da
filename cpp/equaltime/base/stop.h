// Stop: tells threads that work on blocks when to end early. It asks the clock, a stop token and a poll, and keeps the
// first exception.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

namespace equaltime {

/// Called about every 50 ms by the thread that started the work. False ends the work early, as does an exception.
using Poll = std::function<bool()>;

/// Conditions that end work early, between two blocks.
struct StopWhen {
  Poll poll = {};
  std::stop_token cancel = {};
  std::optional<double> seconds = {};  // from now
  std::optional<double> pause = {};  // seconds from now, after which a worker that has finished a block takes no other
};

/// Shared by the workers of one call. The thread that makes it is the one that polls.
class Stop {
 public:
  explicit Stop(StopWhen when = {})
      : poll_(std::move(when.poll)),
        cancel_(std::move(when.cancel)),
        deadline_(in(when.seconds)),
        pause_(in(when.pause)) {}

  /// Ends the work early.
  void request() noexcept { requested_ = true; }
  [[nodiscard]] bool requested() const noexcept { return requested_; }
  /// Ends the work early by an exception, of which the first is kept.
  void fail(std::exception_ptr error) noexcept {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    request();
  }
  /// Throws what was kept, if anything was.
  void rethrow() {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
  }

  /// Whether to end now. Every worker asks before it takes a block; only the calling thread polls.
  [[nodiscard]] bool now() noexcept {
    if (requested_.load(std::memory_order_relaxed)) return true;
    const Clock::time_point time = Clock::now();
    if (cancel_.stop_requested() || (deadline_ && time >= *deadline_)) request();
    if (poll_ && std::this_thread::get_id() == caller_ && time - last_poll_ >= kPollInterval) {
      last_poll_ = time;
      try {
        if (!poll_()) request();
      } catch (...) {
        fail(std::current_exception());
      }
    }
    return requested_;
  }

  /// Whether a worker that has finished a block takes no other; what has begun goes on.
  [[nodiscard]] bool pauses() const noexcept { return pause_ && Clock::now() >= *pause_; }

  /// Lets the calling thread go on polling where a pause left it nothing to do but to wait for others.
  void wait_for(const std::atomic<unsigned>& others) noexcept {
    if (std::this_thread::get_id() != caller_) return;
    while (others > 0 && pauses() && !now()) std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kPollInterval{50};
  static constexpr double kMostSeconds =
      1e9;  // a clock holds nine times that; whoever asks for more never waits so long

  static std::optional<Clock::time_point> in(std::optional<double> seconds) {
    if (!seconds || !(*seconds < kMostSeconds)) return {};
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(*seconds));
  }

  Poll poll_;
  std::stop_token cancel_;
  std::optional<Clock::time_point> deadline_, pause_;
  std::thread::id caller_ = std::this_thread::get_id();
  Clock::time_point last_poll_ = Clock::now();
  std::atomic<bool> requested_{false};
  std::mutex mutex_;
  std::exception_ptr error_;
};

}  // namespace equaltime
