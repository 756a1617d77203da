// Works on the blocks of an image in parallel, each by one thread, for passes that need no film.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

#include "equaltime/base/threads.h"
#include "equaltime/transport/kernels.h"

namespace equaltime {

/// Calls what `worker` makes for each thread with one block after the other. `poll`, if there is one, is called about
/// every 50 ms by the calling thread; what it throws ends all work and is thrown on.
template <class MakeWorker>
void for_each_block(const std::vector<PixelBlock>& blocks, unsigned threads, const std::function<void()>& poll,
                    const MakeWorker& worker) {
  constexpr std::chrono::milliseconds kInterval{50};
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  on_threads(threads, [&, caller = std::this_thread::get_id()](unsigned) {
    auto work = worker();
    auto last_poll = std::chrono::steady_clock::now();
    for (std::size_t i = next++; i < blocks.size(); i = next++) {
      work(blocks[i]);
      if (!poll || std::this_thread::get_id() != caller) continue;
      if (const auto now = std::chrono::steady_clock::now(); now - last_poll >= kInterval) {
        last_poll = now;
        try {
          poll();
        } catch (...) {
          error = std::current_exception();
          next = blocks.size();
        }
      }
    }
  });
  if (error) std::rethrow_exception(error);
}

}  // namespace equaltime
