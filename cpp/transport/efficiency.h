// Efficiency: into how many copies the paths of a pixel are worth splitting where they are scattered first. Copies
// lessen the variance that comes after, and cost its rays; they leave alone what comes before. Of all numbers of copies
// the best product of the image's variance and rays has those that grow as the root of a copy's variance over its rays
// (Rath et al. 2022, "EARS", for one vertex of a path). It is learnt from pilot paths that belong to no image, so that
// it depends on the scene and the strategy alone: not on crop, seed or what was rendered before.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace equaltime {

struct Scene;
struct Settings;

class Efficiency {
 public:
  static constexpr std::uint32_t kMostLog2 = 4;

  /// The same for all pixels of a film of this width.
  static Efficiency uniform(std::uint32_t log2_copies) { return {~std::uint64_t{0}, 1, {log2_copies}}; }
  /// One number for each square block of the full film, row-major.
  Efficiency(std::uint64_t block, std::uint64_t blocks_wide, std::vector<std::uint32_t> log2_copies)
      : block_(block), blocks_wide_(blocks_wide), log2_copies_(std::move(log2_copies)) {}

  [[nodiscard]] std::uint32_t log2_copies(std::uint64_t x, std::uint64_t y) const noexcept {
    return log2_copies_[(y / block_) * blocks_wide_ + x / block_];
  }

 private:
  std::uint64_t block_, blocks_wide_;
  std::vector<std::uint32_t> log2_copies_;
};

/// Learns it from pilot paths: the same for any number of threads.
[[nodiscard]] Efficiency learn_efficiency(const Scene& scene, const Settings& settings, unsigned threads);

}  // namespace equaltime
