// Blocks in parallel: each is done once and in order of its beginning, and every way to stop leaves the rest undone.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "equaltime/base/run_blocks.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

/// Counts how often each block is done.
struct Blocks {
  std::vector<std::atomic<int>> done;
  explicit Blocks(std::size_t count) : done(count) {}
  [[nodiscard]] auto worker() {
    return [this] { return [this](std::size_t i) { ++done[i]; }; };
  }
  [[nodiscard]] bool are_done_below(std::size_t end) const {
    for (std::size_t i = 0; i < done.size(); ++i)
      if (done[i] != (i < end ? 1 : 0)) return false;
    return true;
  }
};

TEST("each block is done once, whatever the number of threads") {
  for (const unsigned threads : {1U, 2U, 7U}) {
    Blocks blocks(100), none(0);
    run_blocks(100, threads, blocks.worker());
    run_blocks(0, threads, none.worker());
    CHECK(blocks.are_done_below(100));
  }
}

TEST("items in chunks: the last chunk may be short") {
  for (const std::size_t count : {0U, 1U, 16U, 37U}) {
    Blocks items(count);
    run_items(count, 16, 2, items.worker());
    CHECK(items.are_done_below(count));
  }
}

TEST("each thread has a worker of its own") {
  std::atomic<int> made{0};
  run_blocks(100, 3, [&] {
    ++made;
    return [mine = std::this_thread::get_id()](std::size_t) { CHECK(mine == std::this_thread::get_id()); };
  });
  CHECK(made == 3);
}

TEST("a request ends the work, and what was begun is finished") {
  Blocks blocks(100);
  Stop stop;
  const auto work = [&](std::size_t i) {
    ++blocks.done[i];
    if (i == 40) stop.request();
  };
  const std::size_t begun = run_blocks(100, 2, stop, [&] { return work; });
  CHECK(begun >= 41 && begun < 100 && blocks.are_done_below(begun) && stop.requested());
  stop.rethrow();
}

TEST("the first exception of a worker is thrown on") {
  const auto work = [](std::size_t i) {
    if (i == 10) throw std::out_of_range("block 10");
  };
  check::throws<std::out_of_range>([&] { run_blocks(1000, 3, [&] { return work; }); }, "block 10", __FILE__, __LINE__);
  const auto no_worker = []() -> void (*)(std::size_t) { throw std::bad_alloc(); };
  check::throws<std::bad_alloc>([&] { run_blocks(10, 2, no_worker); }, "bad_alloc", __FILE__, __LINE__);
}

TEST("the calling thread polls; false and an exception of the poll end the work") {
  const auto slow = [] { return [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds{20}); }; };
  const auto caller = std::this_thread::get_id();
  const auto refuse = [&] {
    CHECK(std::this_thread::get_id() == caller);
    return false;
  };
  check::throws<std::runtime_error>([&] { run_blocks(1000, 2, slow, refuse); }, "cancelled", __FILE__, __LINE__);
  const auto interrupt = []() -> bool { throw std::logic_error("interrupted"); };
  check::throws<std::logic_error>([&] { run_blocks(1000, 2, slow, interrupt); }, "interrupted", __FILE__, __LINE__);
}

TEST("a token, a deadline and a pause end the work") {
  const auto slow = [] { return [](std::size_t) { std::this_thread::sleep_for(std::chrono::milliseconds{5}); }; };
  std::stop_source source;
  source.request_stop();
  Stop cancelled({.cancel = source.get_token()});
  CHECK(run_blocks(100, 2, cancelled, slow) == 0 && cancelled.requested());
  Stop late({.seconds = 0.0});
  CHECK(run_blocks(100, 2, late, slow) == 0 && late.requested());
  Stop paused({.pause = 0.0});
  const std::size_t begun = run_blocks(100, 2, paused, slow);  // a worker has finished a block, so that callers go on
  CHECK(begun >= 1 && begun <= 2 && !paused.requested());
  Stop patient({.seconds = 1e300});
  CHECK(run_blocks(10, 2, patient, slow) == 10);
}

}  // namespace

int main() { return check::run(); }
