#include "equaltime/build/build_materials.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace equaltime {

namespace {

void set(Bsdf& bsdf, BsdfParameter parameter, const Spectrum& value) noexcept {
  std::visit(
      [&](auto& leaf) noexcept {
        if constexpr (requires { leaf.set(parameter, value); }) leaf.set(parameter, value);
      },
      bsdf);
}

bool is_of_azimuth(BsdfParameter p) noexcept {
  return p == BsdfParameter::alpha_u || p == BsdfParameter::alpha_v || p == BsdfParameter::anisotropic;
}

Bsdf make_bsdf(const BsdfDescription& description) {
  struct Make {
    Bsdf operator()(const DiffuseDescription& d) const noexcept { return Diffuse(d); }
    Bsdf operator()(const ConductorDescription& d) const noexcept { return Conductor(d); }
    Bsdf operator()(const RoughConductorDescription& d) const noexcept { return RoughConductor(d); }
    Bsdf operator()(const DielectricDescription& d) const noexcept { return Dielectric(d); }
    Bsdf operator()(const ThinDielectricDescription& d) const noexcept { return ThinDielectric(d); }
    Bsdf operator()(const RoughDielectricDescription& d) const noexcept {
      // Facets of no contrast bend nothing: light passes straight on, however rough they are.
      if (static_cast<float>(d.dielectric.ior) == 1) return Dielectric(d.dielectric);
      return RoughDielectric(d);
    }
    Bsdf operator()(const PlasticDescription& d) const noexcept { return Plastic(d); }
    Bsdf operator()(const PrincipledDescription& d) const noexcept { return Principled(d); }
    Bsdf operator()(const RoughPlasticDescription& d) const { return RoughPlastic(d); }
    // Never asked for their light: nothing is passed through, and of a mixture one part is picked.
    Bsdf operator()(const NullDescription&) const noexcept { return Diffuse({}); }
    Bsdf operator()(const MixtureDescription&) const noexcept { return Diffuse({}); }
  };
  return std::visit(Make{}, description);
}

Material make_material(const BsdfDescription& d) {
  Material material{make_bsdf(d)};
  if (std::holds_alternative<NullDescription>(d)) material.kind = Material::Kind::nothing;
  if (const auto* mixture = std::get_if<MixtureDescription>(&d)) {
    material.kind = Material::Kind::mixture;
    material.parts[0] = mixture->first, material.parts[1] = mixture->second;
    if (mixture->cutoff) material.cutoff = static_cast<float>(*mixture->cutoff);
    material.weight = as_weight(static_cast<float>(mixture->weight), material.cutoff);
  }
  return material;
}

void bind(Material& material, const TextureBinding& b, const std::vector<Texture>& textures) {
  const std::uint32_t last = std::max(b.texture, b.times.value_or(0));
  if (last >= textures.size()) throw std::invalid_argument("no texture " + std::to_string(last) + " to bind");
  const BsdfParameter parameter = b.parameter;
  const Texture& texture = textures[b.texture];
  if (!constant(texture) || b.times) {
    material.bindings.push_back({parameter, b.texture, b.times.value_or(kNone)});
    material.anisotropic = material.anisotropic || is_of_azimuth(parameter);
  } else if (parameter == BsdfParameter::weight) {
    material.weight = as_weight(number(texture, {}), material.cutoff);
  } else {
    set(material.bsdf, parameter, value_for(parameter, texture, {}));
  }
}

/// Whether a bump or normal map leaves every normal as it is: squares of one height each have no slope anywhere. The
/// grey of 128 of 255 in maps of bytes is not quite flat: it leans by a third of a degree.
bool is_flat(const BendDescription& b, const Texture& texture) noexcept {
  const auto color = constant(texture);
  if (b.bump) return b.scale == 0 || color || std::holds_alternative<Checkerboard>(texture);
  return color && 2 * color->r - 1 == 0 && 2 * color->g - 1 == 0 && 2 * color->b - 1 > 0;
}

/// What a material takes from its parts, which come before it.
void complete(std::vector<Material>& materials, std::uint32_t index) {
  Material& m = materials[index];
  m.textured = !m.bindings.empty() || m.bend;
  m.anisotropic = m.anisotropic || is_anisotropic(m.bsdf);
  m.passes = m.kind == Material::Kind::nothing || std::holds_alternative<ThinDielectric>(m.bsdf);
  if (m.kind != Material::Kind::mixture) return;
  for (std::uint32_t& part : m.parts) {
    if (part >= index) throw std::invalid_argument("BSDF " + std::to_string(index) + ": a mixture follows its parts");
    part = folded(materials, part);
    m.textured = m.textured || materials[part].textured;
    m.anisotropic = m.anisotropic || materials[part].anisotropic;
    m.passes = m.passes || materials[part].passes;
  }
}

}  // namespace

std::vector<Material> make_materials(const SceneDescription& description, const std::vector<Texture>& textures,
                                     double length_scale) {
  std::vector<Material> materials;
  for (const BsdfDescription& d : description.bsdfs) materials.push_back(make_material(d));
  for (const TextureBinding& b : description.bindings) {
    if (b.bsdf >= materials.size()) throw std::invalid_argument("no BSDF " + std::to_string(b.bsdf) + " to bind to");
    bind(materials[b.bsdf], b, textures);
  }
  for (const BendDescription& b : description.bends) {
    if (b.bsdf >= materials.size()) throw std::invalid_argument("no BSDF " + std::to_string(b.bsdf) + " to bend");
    if (b.texture >= textures.size())
      throw std::invalid_argument("no texture " + std::to_string(b.texture) + " to bend by");
    if (is_flat(b, textures[b.texture])) continue;
    const auto scale = static_cast<float>(b.scale * length_scale);
    materials[b.bsdf].bend = Bend{b.texture, b.bump, b.flip_invalid, b.shadowing, b.turned, scale};
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
