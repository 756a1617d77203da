// Numbers the different corners of the faces of a mesh: what each names is a few words of 32 bits.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "equaltime/base/bits.h"

namespace equaltime {

// Numbers different corners 0, 1, 2 … in the order in which they come: open addressing over a power of two, at most
// half full, that keeps the numbers only.
template <std::size_t N>
class CornerTable {
 public:
  using Corner = std::array<std::uint32_t, N>;

  std::uint32_t number(const Corner& corner, std::vector<Corner>& corners) {
    if (2 * (corners.size() + 1) > slots_.size()) grow(corners);
    std::uint32_t& slot = *find(corner, corners);
    if (slot == kFree) {
      slot = static_cast<std::uint32_t>(corners.size());
      corners.push_back(corner);
    }
    return slot;
  }

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

  static std::uint64_t hash(const Corner& corner) noexcept {
    std::uint64_t h = 0;
    for (const std::uint32_t word : corner) h = (h ^ (h >> 32) ^ word) * kGolden;
    return h ^ (h >> 32);
  }
  std::uint32_t* find(const Corner& corner, const std::vector<Corner>& corners) noexcept {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = hash(corner) & mask;; i = (i + 1) & mask) {
      if (slots_[i] == kFree || corners[slots_[i]] == corner) return &slots_[i];
    }
  }
  void grow(const std::vector<Corner>& corners) {
    slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kFree);
    for (std::size_t i = 0; i < corners.size(); ++i) *find(corners[i], corners) = static_cast<std::uint32_t>(i);
  }

  std::vector<std::uint32_t> slots_;
};

}  // namespace equaltime
