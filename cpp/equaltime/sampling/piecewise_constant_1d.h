// PiecewiseConstant1D: choose one of n with stated probabilities by inverting their running sum, in order, so that
// numbers that are spread evenly give choices that are. A guide says where to look, so that a choice takes a step or
// two.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace equaltime {

class PiecewiseConstant1D {
 public:
  PiecewiseConstant1D() = default;
  /// Weights are finite and >= 0. An entry of weight 0 is never chosen, unless all are.
  explicit PiecewiseConstant1D(std::span<const double> weights);

  struct Choice {
    std::uint32_t index;
    double rest;  // the number's place within what chooses this entry, in [0, 1]
  };
  [[nodiscard]] Choice choose(double u) const noexcept;
  [[nodiscard]] double pmf(std::uint32_t index) const noexcept { return running_[index + 1] - running_[index]; }
  /// The sum of the weights.
  [[nodiscard]] double total() const noexcept { return total_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return running_.size() * sizeof(double) + guide_.size() * sizeof(std::uint32_t);
  }

 private:
  std::vector<double> running_;       // n + 1 of them, from 0 to exactly 1
  std::vector<std::uint32_t> guide_;  // the entry that each of n + 1 evenly spaced numbers chooses
  double total_ = 0;
};

}  // namespace equaltime
