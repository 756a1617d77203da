// Where in a scene an area light is.
#pragma once

#include <cstdint>

namespace equaltime {

/// The place of an area light; primitive: a triangle, or the number among spheres, disks or cylinders.
struct Emitter {
  std::uint32_t shape, primitive;
};

}  // namespace equaltime
