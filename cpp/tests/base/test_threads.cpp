// Workers on threads: every one runs once, and calls without number leave no memory behind.
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <thread>
#include <vector>

#include "equaltime/base/threads.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

// Sanitizers keep what is freed.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kMemoryTells = false;
#else
constexpr bool kMemoryTells = true;
#endif

long resident_bytes() {
  long whole = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> whole >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

TEST("each worker runs once, whatever the machine has") {
  for (const unsigned threads : {1U, 2U, 7U}) {
    std::vector<std::atomic<int>> runs(threads);
    on_threads(threads, [&](unsigned i) { ++runs[i]; });
    for (const auto& count : runs) CHECK(count == 1);
  }
}

TEST("calls leave no memory behind, on a busy machine either") {
  std::atomic<bool> over{false};
  std::vector<std::thread> others;
  for (unsigned i = 0; i < std::thread::hardware_concurrency(); ++i)
    others.emplace_back([&] {
      while (!over) std::this_thread::yield();
    });
  const auto call = [] {
    std::atomic<int> sum{0};
    on_threads(2, [&](unsigned) {
      for (int i = 0; i < 2000; ++i) sum.fetch_add(i, std::memory_order_relaxed);
    });
  };
  for (int i = 0; i < 100; ++i) call();
  const long before = resident_bytes();
  for (int i = 0; i < 3000; ++i) call();
  const long grown = resident_bytes() - before;
  over = true;
  for (std::thread& t : others) t.join();
  CHECK(!kMemoryTells || grown < (4L << 20));
}

}  // namespace

int main() { return check::run(); }
