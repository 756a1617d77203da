// Materials and textures, from their description.
#pragma once

#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/scene/material.h"

namespace equaltime {

/// Returns a material for each BSDF of the description. A texture of one colour becomes a constant of the leaf.
/// `length_scale` takes lengths to the scene's space; `tables` must outlive the materials. Throws std::invalid_argument
/// for an index that is out of range.
[[nodiscard]] std::vector<Material> make_materials(const SceneDescription& description,
                                                   const std::vector<Texture>& textures, double length_scale,
                                                   BsdfTables& tables);
/// Returns the textures of the description. A texture of one colour keeps no texels.
[[nodiscard]] std::vector<Texture> make_textures(std::vector<TextureDescription> descriptions);

}  // namespace equaltime
