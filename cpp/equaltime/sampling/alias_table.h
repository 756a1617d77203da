// AliasTable: choose one of n in constant time with stated probabilities (Walker 1977, Vose 1991).
// Built in float64, chosen with 64-bit integers: weights may span twelve decades and more.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace equaltime {

class AliasTable {
 public:
  AliasTable() = default;
  /// Weights are finite and >= 0. With no positive weight the table is empty; an entry of weight 0 is never chosen.
  explicit AliasTable(std::span<const double> weights);

  [[nodiscard]] bool empty() const noexcept { return bins_.empty(); }
  [[nodiscard]] std::uint32_t sample(std::uint64_t bits) const noexcept {
    const auto product = static_cast<unsigned __int128>(bits) * bins_.size();
    const auto index = static_cast<std::uint32_t>(product >> 64);
    const Bin& bin = bins_[index];
    return static_cast<std::uint64_t>(product) < bin.threshold ? index : bin.alias;
  }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return bins_.size() * sizeof(Bin); }
  [[nodiscard]] float pmf(std::uint32_t index) const noexcept { return bins_[index].pmf; }

 private:
  struct Bin {
    std::uint64_t threshold;  // of 2^64: below it the bin's own index is taken
    std::uint32_t alias;
    float pmf;
  };
  std::vector<Bin> bins_;
};

}  // namespace equaltime
