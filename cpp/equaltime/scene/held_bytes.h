// The memory that a list holds, in bytes.
#pragma once

#include <vector>

namespace equaltime {

template <class T>
[[nodiscard]] std::size_t held(const std::vector<T>& list) noexcept {
  return list.capacity() * sizeof(T);
}

}  // namespace equaltime
