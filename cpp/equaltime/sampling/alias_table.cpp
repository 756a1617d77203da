#include "equaltime/sampling/alias_table.h"

#include <algorithm>

namespace equaltime {

namespace {

constexpr std::uint64_t kAlways = ~std::uint64_t{0};

std::uint64_t threshold_of(double share) {
  return share >= 1 ? kAlways : static_cast<std::uint64_t>(std::max(share, 0.0) * 0x1p64);
}

}  // namespace

AliasTable::AliasTable(std::span<const double> weights) {
  // Scaling by the largest weight first keeps the sum finite for any finite weights.
  const double largest = weights.empty() ? 0 : *std::max_element(weights.begin(), weights.end());
  if (!(largest > 0)) return;
  double sum = 0;
  for (const double w : weights) sum += w / largest;
  const auto n = weights.size();
  bins_.resize(n);
  std::vector<double> share(n);  // n times the probability; what is still to be placed in the bin
  std::vector<std::uint32_t> small, large;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double p = weights[i] / largest / sum;
    share[i] = p * static_cast<double>(n);
    bins_[i] = {kAlways, i, static_cast<float>(p)};
    (share[i] < 1 ? small : large).push_back(i);
  }
  while (!small.empty() && !large.empty()) {
    const std::uint32_t s = small.back();
    const std::uint32_t l = large.back();
    small.pop_back();
    bins_[s].threshold = threshold_of(share[s]);
    bins_[s].alias = l;
    share[l] -= 1 - share[s];
    if (share[l] < 1) {
      large.pop_back();
      small.push_back(l);
    }
  }
  // What rounding leaves over has a share of 1 but for rounding; an entry that must never be chosen hands its bin on.
  const auto heaviest = static_cast<std::uint32_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  for (const std::uint32_t i : small)
    if (weights[i] == 0) bins_[i] = {0, heaviest, 0.0F};
}

}  // namespace equaltime
