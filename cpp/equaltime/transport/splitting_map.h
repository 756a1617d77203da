// SplittingMap: the number of copies into which each pixel's paths are split at their first vertex; plain values,
// for the kernels. render/splitting.h chooses the numbers.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace equaltime {

class SplittingMap {
 public:
  static constexpr std::uint32_t kMostLog2 = 4;

  /// One number for all pixels.
  static SplittingMap uniform(std::uint32_t log2_copies) { return {~std::uint64_t{0}, 1, {log2_copies}}; }
  /// One number for each square block of the full film, row-major.
  SplittingMap(std::uint64_t block, std::uint64_t blocks_wide, std::vector<std::uint32_t> log2_copies)
      : block_(block), blocks_wide_(blocks_wide), log2_copies_(std::move(log2_copies)) {}

  [[nodiscard]] std::uint32_t log2_copies(std::uint64_t x, std::uint64_t y) const noexcept {
    return log2_copies_[(y / block_) * blocks_wide_ + x / block_];
  }

 private:
  std::uint64_t block_, blocks_wide_;
  std::vector<std::uint32_t> log2_copies_;
};

}  // namespace equaltime
