// Runs one worker on each of a number of threads, and waits for all of them.
#pragma once

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>

namespace equaltime {

/// The number of threads that was asked for; as many as the machine has for 0.
inline unsigned thread_count(unsigned asked) {
  return asked > 0 ? asked : static_cast<unsigned>(tbb::info::default_concurrency());
}

/// The arena of the calling thread for so many threads, kept: one that ends while a worker is on its way out leaves
/// some 7 kB behind (oneTBB 2021.8, on a busy machine), and renders have many passes.
inline tbb::task_arena& arena_of(unsigned threads) {
  thread_local std::map<unsigned, tbb::task_arena> arenas;
  return arenas.try_emplace(threads, static_cast<int>(threads)).first->second;
}

/// Calls f in an arena of oneTBB with this number of threads, the calling one included. The number may exceed the
/// machine's, so that determinism over threads can be shown anywhere.
template <class F>
void in_arena(unsigned threads, const F& f) {
  const std::size_t allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism,
                                        std::max<std::size_t>(allowed, threads));
  arena_of(threads).execute(f);
}

/// Calls worker(i) for each i below `threads`, each on a thread of its own.
template <class Worker>
void on_threads(unsigned threads, const Worker& worker) {
  in_arena(threads, [&] { tbb::parallel_for(0U, threads, worker, tbb::simple_partitioner{}); });
}

}  // namespace equaltime
