// SampleSchedule: how many samples each pixel has once the image has so many on average. All pixels have the same, or,
// after an equal pilot, each grows at a rate of its own. Counts never fall as the average grows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <vector>

namespace equaltime {

class SampleSchedule {
 public:
  SampleSchedule() = default;
  /// `rates`: samples that each pixel (row-major) gets for one of the average, beyond the pilot. Counts beyond it grow
  /// by whole rounds of the replicates, so that these stay alike.
  SampleSchedule(std::uint64_t pilot, std::vector<float> rates, std::uint32_t replicates)
      : pilot_(pilot), replicates_(replicates), rates_(std::move(rates)) {
    if (pilot % replicates != 0) throw std::invalid_argument("the pilot's samples do not divide into the replicates");
    for (const float rate : rates_)
      if (!(rate >= 0 && rate <= kMostRate)) throw std::invalid_argument("a rate is negative, too large or no number");
  }

  [[nodiscard]] std::uint64_t count(std::size_t pixel, std::uint64_t average) const noexcept {
    if (rates_.empty() || average <= pilot_) return average;
    const double rounds = static_cast<double>(average - pilot_) * static_cast<double>(rates_[pixel]) / replicates_;
    return pilot_ + replicates_ * static_cast<std::uint64_t>(rounds + 0.5);
  }

 private:
  static constexpr float kMostRate = 1e6F;  // keeps counts far from 2^64

  std::uint64_t pilot_ = 0;
  std::uint32_t replicates_ = 1;
  std::vector<float> rates_;
};

}  // namespace equaltime
