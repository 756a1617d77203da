// ImageDistribution: a density over the unit square, constant in each cell of a grid, and points drawn in proportion to
// it. For a texture that shines, over the square of a rectangle's own coordinates (textures/texture_distribution.h).
#pragma once

#include <cstddef>
#include <vector>

#include "equaltime/math/point.h"
#include "equaltime/sampling/piecewise_constant_2d.h"

namespace equaltime {

class ImageDistribution {
 public:
  /// Of integrals over the cells between lines of u and of v, from 0 to 1, row by row.
  ImageDistribution(std::vector<double> u, std::vector<double> v, std::vector<double> weights);
  /// Of integrals over so many cells along each side, all of a size, row by row; a share is spread over all of them.
  ImageDistribution(std::size_t cells, std::vector<double> weights);

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
  PiecewiseConstant2D cells_;
  double contrast_ = 1;
};

}  // namespace equaltime
