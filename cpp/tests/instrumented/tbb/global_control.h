// See parallel_for.h: threads are not limited.
#pragma once

#include <cstddef>

namespace tbb {

struct global_control {
  enum parameter { max_allowed_parallelism };
  global_control(parameter, std::size_t) {}
  [[nodiscard]] static std::size_t active_value(parameter) { return 1; }
};

}  // namespace tbb
