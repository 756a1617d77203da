// Affine transforms in float64, row-major, column vectors: p' = M·p. Used at load time and for camera rays.
#pragma once

#include <array>

#include "equaltime/math/vector.h"

namespace equaltime {

struct Transform {
  std::array<std::array<double, 4>, 4> m{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};

  [[nodiscard]] Vec3d point(const Vec3d& p) const noexcept { return vector(p) + Vec3d{m[0][3], m[1][3], m[2][3]}; }
  [[nodiscard]] Vec3d vector(const Vec3d& v) const noexcept {
    return {m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z, m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
            m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
  }
  [[nodiscard]] Vec3d column(std::size_t i) const noexcept { return {m[0][i], m[1][i], m[2][i]}; }
};

}  // namespace equaltime
