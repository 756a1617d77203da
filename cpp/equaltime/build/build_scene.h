// build_scene: from the description of a scene to what paths meet.
#pragma once

#include "equaltime/build/description.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

/// Throws std::invalid_argument that names the shape and what is wrong: a vertex that is not finite, an index out of
/// range.
[[nodiscard]] Scene build_scene(SceneDescription description, Intersection mode = Intersection::robust);
/// Builds a scene without calling `check`. The caller must have checked the numbers as strictly; Python's readers do.
[[nodiscard]] Scene build_checked_scene(SceneDescription description, Intersection mode = Intersection::robust);

}  // namespace equaltime
