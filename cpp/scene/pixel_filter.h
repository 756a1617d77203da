// Filter importance sampling (Ernst, Stamminger & Greiner 2006): a sample's place is drawn from its pixel's filter, so
// that it touches one pixel and pixels stay independent.
#pragma once

#include <vector>

#include "sampling/ordered_table.h"
#include "sampling/sampler.h"
#include "scene/description.h"

namespace equaltime {

class PixelFilter {
 public:
  PixelFilter() = default;
  PixelFilter(FilterKind kind, double parameter);

  struct Offset {
    double x, y;   // pixels from the pixel's centre
    float weight;  // filter over density: 1, or close to it for the Gaussian, whose density is tabulated
  };
  [[nodiscard]] Offset sample(Point2f u) const noexcept;
  /// Half the filter's width, in pixels.
  [[nodiscard]] double radius() const noexcept { return radius_; }

 private:
  struct Offset1d {
    double x;
    double weight;
  };
  [[nodiscard]] Offset1d sample_gaussian(float u) const noexcept;
  [[nodiscard]] double gaussian(double x) const noexcept;
  /// Where an interval of the table begins, or a place within it.
  [[nodiscard]] double place(double interval) const noexcept;

  FilterKind kind_ = FilterKind::box;
  double radius_ = 0.5;
  double deviation_ = 0.5;
  double scale_ = 1;             // of the weights
  std::vector<double> heights_;  // of the Gaussian, at the ends of the intervals
  OrderedTable intervals_;
};

}  // namespace equaltime
