// The few calls of oneTBB that the renderer makes, on std::thread, for ThreadSanitizer builds only. Debian's oneTBB is
// not instrumented: the sanitizer cannot see its fork and join, and would report every datum that crosses them. Through
// these stand-ins it sees all of them, so that nothing of ours needs to be suppressed.
#pragma once

#include <thread>
#include <vector>

namespace tbb {

struct simple_partitioner {};

/// f(i) for every i in [first, last), each on a thread of its own but the first, which the caller takes.
template <class Index, class F>
void parallel_for(Index first, Index last, const F& f, simple_partitioner = {}) {
  std::vector<std::thread> others;
  for (Index i = first + 1; i < last; ++i) others.emplace_back([&f, i] { f(i); });
  if (first < last) f(first);
  for (std::thread& t : others) t.join();
}

}  // namespace tbb
