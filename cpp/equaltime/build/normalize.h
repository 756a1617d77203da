// The normalised space of a scene, and of each group of shapes.
#pragma once

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"

namespace equaltime {

[[nodiscard]] Normalization normalization_of(const SceneDescription& description);
/// Of a group's own space: its origin is the middle of its shapes.
[[nodiscard]] Normalization normalization_of(const GroupDescription& group);

}  // namespace equaltime
