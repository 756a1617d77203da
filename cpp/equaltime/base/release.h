// release: frees what a list holds. Assigning {} to it would keep the memory.
#pragma once

#include <vector>

namespace equaltime {

template <class... T>
void release(std::vector<T>&... lists) noexcept {
  (std::vector<T>().swap(lists), ...);
}

}  // namespace equaltime
