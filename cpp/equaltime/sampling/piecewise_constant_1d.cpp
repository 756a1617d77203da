#include "equaltime/sampling/piecewise_constant_1d.h"

#include <algorithm>

#include "equaltime/sampling/piecewise_constant_2d.h"

namespace equaltime {

PiecewiseConstant1D::PiecewiseConstant1D(std::span<const double> weights) : running_(weights.size() + 1, 0) {
  for (std::size_t i = 0; i < weights.size(); ++i) running_[i + 1] = running_[i] + weights[i];
  total_ = running_.back();
  if (!(total_ > 0)) return;
  for (double& r : running_) r /= total_;
  running_.back() = 1;
  const std::size_t n = weights.size();
  guide_.reserve(n + 1);
  for (std::size_t i = 0; i <= n; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(n);
    const auto above = std::upper_bound(running_.begin() + 1, running_.end() - 1, u);
    guide_.push_back(static_cast<std::uint32_t>(above - running_.begin() - 1));
  }
}

PiecewiseConstant1D::Choice PiecewiseConstant1D::choose(double u) const noexcept {
  if (guide_.empty()) return {0, 0.5};
  const std::size_t n = guide_.size() - 1;
  const std::size_t g = std::min(static_cast<std::size_t>(u * static_cast<double>(n)), n - 1);
  // The product may round up to the next entry of the guide: what is chosen lies no further back than one before it.
  const std::uint32_t first = guide_[g > 0 ? g - 1 : 0], last = guide_[g + 1];
  const auto begin = running_.begin() + 1;
  const auto above = std::upper_bound(begin + first, begin + last, u);
  const auto index = static_cast<std::uint32_t>(above - begin);
  const double lo = running_[index], hi = running_[index + 1];
  return {index, hi > lo ? (u - lo) / (hi - lo) : 0.5};
}

PiecewiseConstant2D::PiecewiseConstant2D(std::span<const double> weights, std::size_t width)
    : PiecewiseConstant2D(weights.size() / width,
                          [&](std::size_t row) { return weights.subspan(row * width, width); }) {}

PiecewiseConstant2D::PiecewiseConstant2D(std::size_t rows,
                                         const std::function<std::span<const double>(std::size_t)>& weights_of) {
  std::vector<double> totals;
  totals.reserve(rows), columns_.reserve(rows);
  for (std::size_t row = 0; row < rows; ++row) totals.push_back(columns_.emplace_back(weights_of(row)).total());
  rows_ = PiecewiseConstant1D(totals);
}

std::size_t PiecewiseConstant2D::memory_bytes() const noexcept {
  std::size_t bytes = rows_.memory_bytes() + columns_.size() * sizeof(PiecewiseConstant1D);
  for (const PiecewiseConstant1D& row : columns_) bytes += row.memory_bytes();
  return bytes;
}

}  // namespace equaltime
