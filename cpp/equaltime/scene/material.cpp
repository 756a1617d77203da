#include "equaltime/scene/material.h"

#include <algorithm>

namespace equaltime {

namespace {

/// Interpolation between vertices of one weight rounds it by a few ulps, which must not make holes.
constexpr float kRounded = 1 - 0x1p-21F;

}  // namespace

float as_weight(float value, std::optional<float> cutoff) noexcept {
  return cutoff ? (value >= *cutoff * kRounded ? 1.0F : 0.0F) : std::clamp(value, 0.0F, 1.0F);
}

std::optional<Spectrum> constant(const Texture& texture) noexcept {
  return std::visit([](const auto& t) noexcept { return t.constant(); }, texture);
}

const Bsdf& Material::at(const std::vector<Texture>& textures, const TextureCoords& place,
                         std::optional<Bsdf>& made) const noexcept {
  // Copies the model, not the variant, which is as large as its largest model.
  return visit<kAllEffects>(bsdf, [&](auto model) noexcept -> const Bsdf& {
    give(model, bindings, textures, place);
    return made.emplace(model);
  });
}

float Material::weight_at(const std::vector<Texture>& textures, const TextureCoords& place) const noexcept {
  if (bindings.empty()) return weight;
  const auto& [slot, texture, times] = bindings.front();
  const float factor = times == kNone ? 1.0F : number(textures[times], place);
  return as_weight(factor * number(textures[texture], place), cutoff);
}

std::uint32_t resolve_constant_blend(const std::vector<Material>& materials, std::uint32_t index) noexcept {
  const Material& m = materials[index];
  if (m.kind != Material::Kind::mixture) return index;
  const bool decided = m.bindings.empty() && (m.weight <= 0 || m.weight >= 1);
  if (!decided && m.parts[0] != m.parts[1]) return index;
  return resolve_constant_blend(materials, m.parts[decided && m.weight >= 1 ? 1 : 0]);
}

}  // namespace equaltime
