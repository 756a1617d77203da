// Material of one side of a surface: a leaf (a BSDF with its textures), a null material, or a mixture of two materials.
// At a point, one part of a mixture is picked. The BSDF of a leaf with textures is copied, and its parameters are set
// from them; a leaf without textures is not copied.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "equaltime/bsdfs/bsdf.h"
#include "equaltime/bsdfs/texture_slots.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

/// See NormalMapDescription; the scale is of normalised lengths.
struct NormalMap {
  std::uint32_t texture;
  bool bump, flip_invalid, shadowing, negate_back;
  float scale;
};

struct Material {
  struct Binding {
    std::uint32_t slot;  // in the model's `textured`; 0 of a mixture
    std::uint32_t texture;
    std::uint32_t times;  // another that multiplies it, or kNone
  };

  enum class Kind : std::uint8_t { leaf, null, mixture };

  Bsdf bsdf;  // of a leaf, before its textures are applied
  std::vector<Binding> bindings = {};
  std::optional<NormalMap> normal_map = {};
  Kind kind = Kind::leaf;
  // True if it holds for the material or any part of it:
  bool textured = false;
  bool anisotropic = false;          // the BSDF depends on the shading frame's tangent
  bool passes = false;               // null material or thin glass: light may pass straight through
  std::uint32_t parts[2] = {0, 0};   // of a mixture
  float weight = 0;                  // of the second part, if no texture gives it
  std::optional<float> cutoff = {};  // see MixtureDescription

  /// The leaf's BSDF with its textures looked up at a point; `made` stores it.
  const Bsdf& at(const std::vector<Texture>& textures, const TextureCoords& place,
                 std::optional<Bsdf>& made) const noexcept;
  /// Weight of the second part of a mixture at a point.
  [[nodiscard]] float weight_at(const std::vector<Texture>& textures, const TextureCoords& place) const noexcept;
};

/// Index of the material itself or, if a mixture always picks the same part, of that part.
[[nodiscard]] std::uint32_t resolve_constant_blend(const std::vector<Material>& materials,
                                                   std::uint32_t index) noexcept;
/// Weight of the second part of a mixture: `value` clamped to [0, 1], or 0 or 1 by the cutoff.
[[nodiscard]] float as_weight(float value, std::optional<float> cutoff) noexcept;
/// Sets the parameters of a model that have textures, at a point.
template <class Model>
void give(Model& model, std::span<const Material::Binding> bindings, const std::vector<Texture>& textures,
          const TextureCoords& at) noexcept {
  static constexpr auto kSlots = Model::textured();
  for (const auto& [index, texture, times] : bindings)
    for_each_of(kSlots, [&, first = texture, second = times, wanted = index](const auto& slot, std::size_t i) noexcept {
      if (i != wanted) return;
      const auto value = [&](std::uint32_t t) noexcept {
        if constexpr (std::is_same_v<typename std::decay_t<decltype(slot)>::value_type, float>)
          return number(textures[t], at);
        else
          return eval(textures[t], at);
      };
      slot.give(model, second == kNone ? value(first) : value(first) * value(second));
    });
  if constexpr (requires { model.derive(); }) model.derive();
}

/// The colour of a texture that is constant; nothing for others.
[[nodiscard]] std::optional<Spectrum> constant(const Texture& texture) noexcept;
}  // namespace equaltime
