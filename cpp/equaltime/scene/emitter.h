// Emitter: the shape and primitive of an area light.
#pragma once

#include <cstdint>

namespace equaltime {

/// `primitive`: the triangle of a mesh, or the number among all analytic shapes of the kind.
struct Emitter {
  std::uint32_t shape, primitive;
};

}  // namespace equaltime
