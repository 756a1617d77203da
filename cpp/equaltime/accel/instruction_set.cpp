#include "equaltime/accel/instruction_set.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <stdexcept>

namespace equaltime {
namespace {

struct Isa {
  const char* name;
  bool there;
};

#ifdef __x86_64__
/// From the least to the best, as Embree 3.13 and 4 choose among them.
const Isa kSets[] = {
    {"sse4.2", __builtin_cpu_supports("sse4.2") != 0},
    {"avx", __builtin_cpu_supports("avx") != 0},
    {"avx2", __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")},
    {"avx512", __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
                   __builtin_cpu_supports("avx512vl")},
};
#else
const Isa kSets[] = {{"neon", true}};
#endif

/// Null while nothing is held. Scenes are built on any thread.
std::atomic<const Isa*> held{nullptr};

}  // namespace

void hold_embree(const std::string& isa) {
  const auto found = std::find_if(std::begin(kSets), std::end(kSets), [&](const Isa& s) { return isa == s.name; });
  if (found == std::end(kSets)) throw std::invalid_argument("Embree knows no instruction set '" + isa + "'");
  if (!found->there) throw std::invalid_argument("this machine has no " + isa);
  held = &*found;
}

std::string embree_isa() {
  if (const Isa* isa = held) return isa->name;
  const auto best = std::find_if(std::rbegin(kSets), std::rend(kSets), [](const Isa& s) { return s.there; });
  return best == std::rend(kSets) ? "sse2" : best->name;
}

std::string embree_config() {
  const Isa* isa = held;
  return isa == nullptr ? "" : std::string("isa=") + isa->name;
}

}  // namespace equaltime
