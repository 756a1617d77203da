// The normalised space of a scene, and of each group of shapes.
#pragma once

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"

namespace equaltime {

/// The space of a scene: the camera's place in the geometry's bounds is its origin.
[[nodiscard]] Normalization normalization_of(const SceneDescription& description);
/// The space of a group: the middle of its shapes is its origin.
[[nodiscard]] Normalization normalization_of(const GroupDescription& group);

}  // namespace equaltime
