#include "scene/material.h"

#include <stdexcept>
#include <string>

#include "scene/description.h"

namespace equaltime {

namespace {

void set(Bsdf& bsdf, BsdfParameter parameter, const Spectrum& value) noexcept {
  std::visit([&](auto& leaf) noexcept { leaf.set(parameter, value); }, bsdf);
}

std::optional<Spectrum> constant(const Texture& texture) noexcept {
  return std::visit([](const auto& t) noexcept { return t.constant(); }, texture);
}

bool is_of_azimuth(BsdfParameter p) noexcept { return p == BsdfParameter::alpha_u || p == BsdfParameter::alpha_v; }

}  // namespace

Bsdf Material::at(const std::vector<Texture>& textures, Point2f uv) const noexcept {
  Bsdf leaf = bsdf;
  for (const auto& [parameter, texture] : bindings) set(leaf, parameter, eval(textures[texture], uv));
  return leaf;
}

std::vector<Material> make_materials(const SceneDescription& description, const std::vector<Texture>& textures) {
  std::vector<Material> materials;
  for (const BsdfDescription& d : description.bsdfs) materials.push_back({make_bsdf(d), {}, false});
  for (const auto& [bsdf, parameter, texture] : description.bindings) {
    if (bsdf >= materials.size()) throw std::invalid_argument("no BSDF " + std::to_string(bsdf) + " to bind to");
    if (texture >= textures.size()) throw std::invalid_argument("no texture " + std::to_string(texture) + " to bind");
    if (const auto value = constant(textures[texture])) {
      set(materials[bsdf].bsdf, parameter, *value);
    } else {
      materials[bsdf].bindings.push_back({parameter, texture});
      materials[bsdf].anisotropic = materials[bsdf].anisotropic || is_of_azimuth(parameter);
    }
  }
  for (Material& m : materials) m.anisotropic = m.anisotropic || is_anisotropic(m.bsdf);
  return materials;
}

std::vector<Texture> make_textures(std::vector<TextureDescription> descriptions) {
  std::vector<Texture> textures;
  for (TextureDescription& d : descriptions) {
    textures.push_back(make_texture(std::move(d)));
    if (const auto color = constant(textures.back())) textures.back() = Checkerboard(*color);
  }
  return textures;
}

}  // namespace equaltime
