// Material: a BSDF with what textures say about it. Made at a point: the leaf is copied and its bound parameters set.
// A material without textures is its leaf, and costs no copy.
#pragma once

#include <optional>
#include <vector>

#include "scene/bsdf.h"
#include "scene/texture.h"

namespace equaltime {

struct SceneDescription;

struct Material {
  struct Binding {
    BsdfParameter parameter;
    std::uint32_t texture;
  };

  Bsdf bsdf;  // the leaf, as it is where no texture speaks
  std::vector<Binding> bindings;
  bool anisotropic = false;  // looks at the azimuth of directions, so that the shading frame's tangent matters

  /// The leaf as the textures make it at uv.
  [[nodiscard]] Bsdf at(const std::vector<Texture>& textures, Point2f uv) const noexcept;
};

/// One a BSDF of the description. A texture of one colour becomes a constant of the leaf.
/// Throws std::invalid_argument if a binding names what is not there.
[[nodiscard]] std::vector<Material> make_materials(const SceneDescription& description,
                                                   const std::vector<Texture>& textures);
/// One a texture of the description; those of one colour keep no texels.
[[nodiscard]] std::vector<Texture> make_textures(std::vector<TextureDescription> descriptions);

}  // namespace equaltime
