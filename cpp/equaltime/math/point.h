// Points of a plane: random numbers of a square, texture coordinates, places on a film.
#pragma once

namespace equaltime {

template <class T>
struct Point2 {
  T x, y;
};
using Point2f = Point2<float>;
using Point2d = Point2<double>;

}  // namespace equaltime
