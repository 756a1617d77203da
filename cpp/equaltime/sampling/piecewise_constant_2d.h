// PiecewiseConstant2D: choose a cell of a grid with stated probabilities, the row first and then the column within it,
// each by inverting a running sum: points that are spread evenly over the square choose cells that are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "equaltime/sampling/piecewise_constant_1d.h"

namespace equaltime {

class PiecewiseConstant2D {
 public:
  PiecewiseConstant2D() = default;
  /// Weights row by row, finite and >= 0. A cell of weight 0 is never chosen, unless all are.
  PiecewiseConstant2D(std::span<const double> weights, std::size_t width);
  /// The same, with `weights_of` called for the weights of each row in turn, so that only one row is held at a time.
  PiecewiseConstant2D(std::size_t rows, const std::function<std::span<const double>(std::size_t)>& weights_of);

  struct Choice {
    PiecewiseConstant1D::Choice row, column;
  };
  /// The row by v, the column by u.
  [[nodiscard]] Choice choose(double u, double v) const noexcept {
    const PiecewiseConstant1D::Choice row = rows_.choose(v);
    return {row, columns_[row.index].choose(u)};
  }
  [[nodiscard]] double pmf(std::uint32_t row, std::uint32_t column) const noexcept {
    return rows_.pmf(row) * columns_[row].pmf(column);
  }
  /// The sum of the weights.
  [[nodiscard]] double total() const noexcept { return rows_.total(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  PiecewiseConstant1D rows_;
  std::vector<PiecewiseConstant1D> columns_;  // one a row
};

}  // namespace equaltime
