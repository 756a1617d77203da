// Emitter: the shape and primitive of an area light.
#pragma once

#include <cstdint>

namespace equaltime {

/// `primitive`: the triangle of a mesh, or the number among all spheres, disks or cylinders.
struct Emitter {
  std::uint32_t shape, primitive;
};

}  // namespace equaltime
