// run_blocks: work on numbered blocks by a number of threads, begun in ascending order. All parallel work of the
// renderer and of the passes around it goes through here.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <stdexcept>

#include "equaltime/base/stop.h"
#include "equaltime/base/threads.h"

namespace equaltime {

/// Counts who is at work, for as long as it lives: also if that ends with an exception, which others must not wait for.
class AtWork {
 public:
  explicit AtWork(std::atomic<unsigned>& count) noexcept : count_(count) { ++count_; }
  ~AtWork() { --count_; }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;

 private:
  std::atomic<unsigned>& count_;
};

/// Calls worker(i) for i = 0, 1, … below `count`, where each thread makes its own worker, until `stop` ends it. Every
/// block that was begun is finished, unless its worker throws. An exception ends the work and is kept by `stop`.
/// Returns the number of blocks that were begun: these are the first ones.
template <class MakeWorker>
std::size_t run_blocks(std::size_t count, unsigned threads, Stop& stop, const MakeWorker& make_worker) {
  std::atomic<std::size_t> next{0};
  std::atomic<unsigned> at_work{0};
  const auto take_blocks = [&] {
    const AtWork here(at_work);
    try {
      auto&& worker = make_worker();
      for (bool first = true; !stop.now() && (first || !stop.pauses()); first = false) {
        const std::size_t i = next.fetch_add(1, std::memory_order_relaxed);
        if (i >= count) break;
        worker(i);
      }
    } catch (...) {
      stop.fail(std::current_exception());
    }
  };
  try {
    on_threads(threads, [&](unsigned) {
      take_blocks();
      stop.wait_for(at_work);
    });
  } catch (...) {  // of oneTBB, which may find no memory for its tasks
    stop.fail(std::current_exception());
  }
  return std::min(next.load(), count);
}

/// Works on all blocks, or throws: what a worker or the poll threw, or std::runtime_error if the poll returned false.
template <class MakeWorker>
void run_blocks(std::size_t count, unsigned threads, const MakeWorker& make_worker, const Poll& poll = {}) {
  Stop stop({.poll = poll});
  run_blocks(count, threads, stop, make_worker);
  stop.rethrow();
  if (stop.requested()) throw std::runtime_error("cancelled");
}

/// Works on all items, or throws as `run_blocks` does. Items are short: a block has `chunk` of them.
template <class MakeWorker>
void run_items(std::size_t count, std::size_t chunk, unsigned threads, const MakeWorker& make_worker) {
  run_blocks((count + chunk - 1) / chunk, threads, [&] {
    return [&, worker = make_worker()](std::size_t block) mutable {
      const std::size_t end = std::min(chunk * (block + 1), count);
      for (std::size_t i = chunk * block; i < end; ++i) worker(i);
    };
  });
}

}  // namespace equaltime
