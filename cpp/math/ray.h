// Ray: points origin + t·direction for t in (0, t_max). Its direction is unit where it looks for the nearest surface;
// between two points it is their difference and t_max is 1.
#pragma once

#include "math/numeric.h"
#include "math/vector.h"

namespace equaltime {

struct Ray {
  Vec3f origin;
  Vec3f direction;
  float t_max = kInfinity;
};

}  // namespace equaltime
