// build_scene: from the description of a scene to what paths meet.
#pragma once

#include "equaltime/build/description.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

struct BuildOptions {
  Intersection intersection = Intersection::robust;
  /// Threads that build the acceleration structure, the calling one included. 0: those of the caller's oneTBB arena,
  /// which are as many as the machine has unless the caller made another arena. The scene does not depend on it.
  unsigned threads = 0;
};

/// Builds the scene that a description describes. Throws std::invalid_argument that names the part by kind and index,
/// its number and the range, such as "BSDF 3 (rough plastic): alpha is 0; expected a number from ...". Any number of
/// threads may build scenes at the same time.
[[nodiscard]] Scene build_scene(SceneDescription description, const BuildOptions& options = {});
/// Builds a scene without calling `check`. The caller must have checked the numbers as strictly; Python's readers do.
/// Errors name shapes by their number alone.
[[nodiscard]] Scene build_checked_scene(SceneDescription description, const BuildOptions& options = {});

}  // namespace equaltime
