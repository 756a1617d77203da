// Walls: spheres so large that their boxes hold all that is smaller, such as the sides of a room whose walls are balls.
// In a tree every ray would visit them; beside it they are met one after the other, without its steps and calls back.
// The nearest is so by float64, the first of those that are equally near.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry.h"

namespace equaltime {

class Walls {
 public:
  Walls() = default;
  Walls(const std::vector<SphereGeometry>& spheres, const std::vector<TriangleMesh>& meshes);

  [[nodiscard]] bool empty() const noexcept { return walls_.empty(); }
  /// The number of the nearest that the ray meets before its t_max.
  [[nodiscard]] Optional<std::uint32_t> nearest(RayD ray) const noexcept {
    Optional<std::uint32_t> found;
    for (const auto& [sphere, number] : walls_)
      if (const auto t = intersect_sphere(sphere, ray)) {
        ray.t_max = *t;
        found = number;
      }
    return found;
  }
  /// Whether the ray meets one of them before its t_max.
  [[nodiscard]] bool any(const RayD& ray) const noexcept {
    for (const Wall& wall : walls_)
      if (intersect_sphere(wall.sphere, ray)) return true;
    return false;
  }
  /// The spheres, by the same numbers, with nothing in the place of walls.
  [[nodiscard]] std::vector<SphereGeometry> taken_out_of(std::vector<SphereGeometry> spheres) const {
    for (const Wall& wall : walls_) spheres[wall.number].radius = -kInfinity;  // has no box: Embree leaves it out
    return spheres;
  }

 private:
  struct Wall {
    SphereGeometry sphere;
    std::uint32_t number;
  };
  std::vector<Wall> walls_;  // in ascending order
};

}  // namespace equaltime
