// OrderedTable2D: choose a cell of a grid with stated probabilities, the row first and then the column within it, each
// by inverting a running sum: points that are spread evenly over the square choose cells that are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "equaltime/sampling/ordered_table.h"

namespace equaltime {

class OrderedTable2D {
 public:
  OrderedTable2D() = default;
  /// Weights row by row, finite and >= 0. A cell of weight 0 is never chosen, unless all are.
  OrderedTable2D(std::span<const double> weights, std::size_t width);
  /// The same, with `weights_of` called for the weights of each row in turn, so that only one row is held at a time.
  OrderedTable2D(std::size_t rows, const std::function<std::span<const double>(std::size_t)>& weights_of);

  struct Choice {
    OrderedTable::Choice row, column;
  };
  /// The row by v, the column by u.
  [[nodiscard]] Choice choose(double u, double v) const noexcept {
    const OrderedTable::Choice row = rows_.choose(v);
    return {row, columns_[row.index].choose(u)};
  }
  [[nodiscard]] double pmf(std::uint32_t row, std::uint32_t column) const noexcept {
    return rows_.pmf(row) * columns_[row].pmf(column);
  }
  /// The sum of the weights.
  [[nodiscard]] double total() const noexcept { return rows_.total(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  OrderedTable rows_;
  std::vector<OrderedTable> columns_;  // one a row
};

}  // namespace equaltime
