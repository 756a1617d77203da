#include "equaltime/build/build_materials.h"

#include <algorithm>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include "equaltime/build/part_names.h"

namespace equaltime {

namespace {

/// The model of a description. Null materials and mixtures get a placeholder that is never evaluated.
Bsdf make_bsdf(const BsdfDescription& description, BsdfTables& tables) {
  std::optional<Bsdf> made;
  const auto make = [&]<class Model>(std::type_identity<Model>) {
    const auto* d = std::get_if<typename Model::Description>(&description);
    if (d == nullptr) return;
    if constexpr (requires { Model::simpler(*d); })
      if (const auto simpler = Model::simpler(*d)) {
        made = *simpler;
        return;
      }
    if constexpr (std::is_constructible_v<Model, const typename Model::Description&, BsdfTables&>)
      made = Model(*d, tables);
    else
      made = Model(*d);
  };
  Bsdfs::for_each(make);
  return made.value_or(Diffuse<float>({}));
}

/// Slot of a model's parameter that may have a texture.
struct Slot {
  std::uint32_t index;
  bool azimuthal;
};
std::optional<Slot> slot_of(const Bsdf& bsdf, const std::string& parameter) noexcept {
  return visit<kAllEffects>(bsdf, [&]<class Model>(const Model&) noexcept {
    std::optional<Slot> found;
    for_each_of(Model::textured(), [&](const auto& slot, std::size_t i) noexcept {
      if (parameter == slot.name) found = {static_cast<std::uint32_t>(i), slot.azimuthal};
    });
    return found;
  });
}

Material make_material(const BsdfDescription& d, BsdfTables& tables) {
  Material material{make_bsdf(d, tables)};
  if (std::holds_alternative<NullDescription>(d)) material.kind = Material::Kind::null;
  if (const auto* mixture = std::get_if<MixtureDescription>(&d)) {
    material.kind = Material::Kind::mixture;
    material.parts[0] = mixture->first, material.parts[1] = mixture->second;
    if (mixture->cutoff) material.cutoff = static_cast<float>(*mixture->cutoff);
    material.weight = as_weight(static_cast<float>(mixture->weight), material.cutoff);
  }
  return material;
}

/// `part` is the BSDF's name.
void bind_texture(Material& material, const TextureBinding& b, const std::vector<Texture>& textures,
                  const std::string& part) {
  const std::uint32_t last = std::max(b.texture, b.times.value_or(0));
  if (last >= textures.size()) throw std::invalid_argument("no texture " + std::to_string(last) + " to bind");
  const bool mixes = material.kind == Material::Kind::mixture;
  const std::optional<Slot> slot = mixes ? (b.parameter == "weight" ? std::optional(Slot{0, false}) : std::nullopt)
                                         : slot_of(material.bsdf, b.parameter);
  if (!slot) throw std::invalid_argument(part + ": no texture may give \"" + b.parameter + '"');
  const Material::Binding binding{slot->index, b.texture, b.times.value_or(kNone)};
  if (!constant(textures[b.texture]) || b.times) {
    material.bindings.push_back(binding);
    material.anisotropic = material.anisotropic || slot->azimuthal;
  } else if (mixes) {
    material.weight = as_weight(number(textures[b.texture], {}), material.cutoff);
  } else {
    material.bsdf = visit<kAllEffects>(material.bsdf, [&](auto model) -> Bsdf {
      give(model, std::span(&binding, 1), textures, {});
      return model;
    });
  }
}

/// Whether a bump or normal map leaves every normal as it is: squares of one height each have no slope anywhere. The
/// grey of 128 of 255 in maps of bytes is not quite flat: it leans by a third of a degree.
bool is_flat(const NormalMapDescription& b, const Texture& texture) noexcept {
  const auto color = constant(texture);
  if (b.bump) return b.scale == 0 || color || std::holds_alternative<Checkerboard>(texture);
  return color && 2 * color->r - 1 == 0 && 2 * color->g - 1 == 0 && 2 * color->b - 1 > 0;
}

/// Sets the flags that a material takes from its parts. Parts come before it.
void complete(std::vector<Material>& materials, std::uint32_t index) {
  Material& m = materials[index];
  m.textured = !m.bindings.empty() || m.normal_map;
  m.anisotropic = m.anisotropic || is_anisotropic(m.bsdf);
  m.passes = m.kind == Material::Kind::null || std::holds_alternative<ThinDielectric<float>>(m.bsdf);
  if (m.kind != Material::Kind::mixture) return;
  for (std::uint32_t& part : m.parts) {
    if (part >= index) throw std::invalid_argument("BSDF " + std::to_string(index) + ": a mixture follows its parts");
    part = resolve_constant_blend(materials, part);
    m.textured = m.textured || materials[part].textured;
    m.anisotropic = m.anisotropic || materials[part].anisotropic;
    m.passes = m.passes || materials[part].passes;
  }
}

}  // namespace

std::vector<Material> make_materials(const SceneDescription& description, const std::vector<Texture>& textures,
                                     double length_scale, BsdfTables& tables) {
  std::vector<Material> materials;
  for (const BsdfDescription& d : description.bsdfs) materials.push_back(make_material(d, tables));
  for (const TextureBinding& b : description.bindings) {
    if (b.bsdf >= materials.size()) throw std::invalid_argument("no BSDF " + std::to_string(b.bsdf) + " to bind to");
    bind_texture(materials[b.bsdf], b, textures, bsdf_name(description, b.bsdf));
  }
  for (const NormalMapDescription& b : description.normal_maps) {
    if (b.bsdf >= materials.size()) throw std::invalid_argument("no BSDF " + std::to_string(b.bsdf) + " to bend");
    if (b.texture >= textures.size())
      throw std::invalid_argument("no texture " + std::to_string(b.texture) + " to bend by");
    if (is_flat(b, textures[b.texture])) continue;
    const auto scale = static_cast<float>(b.scale * length_scale);
    materials[b.bsdf].normal_map = NormalMap{b.texture, b.bump, b.flip_invalid, b.shadowing, b.negate_back, scale};
  }
  for (std::uint32_t i = 0; i < materials.size(); ++i) complete(materials, i);
  return materials;
}

std::vector<Texture> make_textures(std::vector<TextureDescription> descriptions) {
  std::vector<Texture> textures;
  for (TextureDescription& d : descriptions) {
    textures.push_back(make_texture(std::move(d)));
    if (const auto color = constant(textures.back()))
      textures.back() = Checkerboard(*color, number(textures.back(), {}));
  }
  return textures;
}

}  // namespace equaltime
