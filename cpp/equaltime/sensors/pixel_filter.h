// Filter importance sampling (Ernst, Stamminger & Greiner 2006): a sample's place is drawn from its pixel's filter, so
// that it touches one pixel and pixels stay independent. A filter with negative lobes is drawn by its absolute value,
// and the weight has its sign: the mean stays that of the filter, and the variance says what the lobes cost.
#pragma once

#include <functional>
#include <vector>

#include "equaltime/math/point.h"
#include "equaltime/sampling/piecewise_constant_1d.h"
#include "equaltime/sensors/sensor_description.h"

namespace equaltime {

class PixelFilter {
 public:
  PixelFilter() = default;
  /// The parameters are those of FilmDescription; throws std::invalid_argument for some that make no filter.
  PixelFilter(FilterKind kind, double parameter, double second = 0);

  struct Offset {
    double x, y;   // pixels from the pixel's centre
    float weight;  // filter over density: 1 for box and tent, close to ±constant for others, whose density is tabulated
  };
  [[nodiscard]] Offset sample(Point2f u) const noexcept;
  /// The density with which a sample is drawn so far from its pixel's centre, in 1 / pixel², and its weight there.
  struct Drawn {
    double density, weight;
  };
  [[nodiscard]] Drawn drawn(double x, double y) const noexcept;
  /// Half the filter's width, in pixels.
  [[nodiscard]] double radius() const noexcept { return radius_; }

 private:
  /// A filter along one axis.
  using Profile = double (*)(double x, double parameter, double second) noexcept;
  struct Offset1d {
    double x;
    double weight;
  };
  void tabulate(Profile profile, double integral);
  [[nodiscard]] Offset1d sample_table(float u) const noexcept;
  [[nodiscard]] Drawn drawn_1d(double x) const noexcept;
  /// Where an interval of the table begins, or a place within it.
  [[nodiscard]] double place(double interval) const noexcept;

  FilterKind kind_ = FilterKind::box;
  double radius_ = 0.5;
  double parameter_ = 0.5, second_ = 0;
  Profile profile_ = nullptr;    // of a tabulated filter
  double scale_ = 1;             // of its weights
  std::vector<double> heights_;  // its absolute value, at the ends of the intervals
  PiecewiseConstant1D intervals_;
};

}  // namespace equaltime
