// Checks of a description's numbers, for those who fill one in without Python's readers.
#pragma once

#include "equaltime/build/description.h"

namespace equaltime {

/// Throws std::invalid_argument unless every number of the BSDFs, phase functions, lights, motions and the sensor is in
/// its range. The message names the part, the number, its value and the range, such as "BSDF 3 (rough plastic): alpha
/// is 0; expected a number from ...". Shapes, extinctions, textures, the pixel filter and the lens are checked where
/// they are made.
void check(const SceneDescription& description);

}  // namespace equaltime
