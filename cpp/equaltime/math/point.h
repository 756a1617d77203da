// Points of a plane: random numbers of a square, texture coordinates, places on a film.
#pragma once

namespace equaltime {

struct Point2f {
  float x, y;
};
struct Point2d {
  double x, y;
};

}  // namespace equaltime
