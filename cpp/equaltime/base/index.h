// The index of nothing: where a list has no such entry.
#pragma once

#include <cstdint>

namespace equaltime {

inline constexpr std::uint32_t kNone = ~std::uint32_t{0};

}  // namespace equaltime
