// The lights that are no surfaces, from their description to normalised space. Part of build_scene.
#pragma once

#include <optional>
#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"
#include "equaltime/scene/lights.h"

namespace equaltime {

/// Throws std::invalid_argument for a place that is not finite, no direction, angles that are none, or no texture.
[[nodiscard]] std::vector<DeltaLight> make_delta_lights(const SceneDescription& description,
                                                        const std::vector<Texture>& textures,
                                                        const Normalization& normalization);
/// None if it is black.
[[nodiscard]] std::optional<Environment> make_environment(SceneDescription& description,
                                                          const Normalization& normalization);

}  // namespace equaltime
