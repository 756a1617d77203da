// Picture: how the radiance of a texture is spread over the unit square of a rectangle's own coordinates, and points
// drawn in proportion to it. Cells lie between the lines along which a bitmap's interpolation changes, so that each
// has its exact integral, and one whose radiance is not all black is never left out; of a texture without such lines,
// or with too many, the square is cut evenly, and a share of the points is spread over all of it.
#pragma once

#include "sampling/ordered_table_2d.h"
#include "sampling/sampler.h"
#include "scene/texture.h"

namespace equaltime {

class Picture {
 public:
  /// Of the mean of the texture's colours, each multiplied by `color`.
  Picture(const Texture& texture, const Spectrum& color);
  /// Of integrals over so many cells along each side, all of a size, row by row; a share is spread over all of them.
  Picture(std::size_t cells, std::vector<double> weights);

  /// The integral over the square: the mean radiance.
  [[nodiscard]] double mean() const noexcept { return cells_.total(); }
  /// The mean square of the density of points, which is 1 if all are alike.
  [[nodiscard]] double contrast() const noexcept { return contrast_; }
  [[nodiscard]] Point2d sample(Point2d u) const noexcept;
  /// Per unit of the square's area.
  [[nodiscard]] double density(double u, double v) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

 private:
  void set_weights(std::vector<double> weights);

  std::vector<double> u_, v_;  // where the cells' sides are, from 0 to 1
  OrderedTable2D cells_;
  double contrast_ = 1;
};

}  // namespace equaltime
