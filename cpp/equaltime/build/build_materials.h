// Materials and textures, from their description.
#pragma once

#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/scene/material.h"

namespace equaltime {

/// One a BSDF of the description. A texture of one colour becomes a constant of the leaf.
/// Lengths are scaled by `length_scale`. Throws std::invalid_argument if something is named that is not there.
[[nodiscard]] std::vector<Material> make_materials(const SceneDescription& description,
                                                   const std::vector<Texture>& textures, double length_scale);
/// One a texture of the description; those of one colour keep no texels.
[[nodiscard]] std::vector<Texture> make_textures(std::vector<TextureDescription> descriptions);

}  // namespace equaltime
