// Texture slots: the table of a BSDF's parameters that textures may give. Materials go through it, so that they know no
// model by name.
#pragma once

#include <tuple>
#include <type_traits>

#include "equaltime/base/fields.h"
#include "equaltime/math/spectrum.h"

namespace equaltime {

/// A parameter that a texture may give: `set` is a member of the model, or a function of it and the value.
template <class Value, class Set>
struct TextureSlot {
  const char* name;
  Set set;
  bool azimuthal = false;  // makes a difference between tangent and bitangent

  using value_type = Value;

  template <class Model>
  void give(Model& model, const Value& value) const noexcept {
    if constexpr (std::is_member_object_pointer_v<Set>)
      model.*set = value;
    else
      set(model, value);
  }
};

template <class Set>
[[nodiscard]] constexpr auto color_slot(const char* name, Set set) noexcept {
  return TextureSlot<Spectrum, Set>{name, set};
}
template <class Set>
[[nodiscard]] constexpr auto number_slot(const char* name, Set set, bool azimuthal = false) noexcept {
  return TextureSlot<float, Set>{name, set, azimuthal};
}

/// The roughness of models that have a `distribution`.
[[nodiscard]] constexpr auto textured_roughness() noexcept {
  return std::tuple{
      number_slot("alpha", [](auto& model, float alpha) noexcept { model.distribution.set_alpha(alpha, alpha); }),
      number_slot(
          "alpha_u",
          [](auto& model, float alpha) noexcept { model.distribution.set_alpha(alpha, model.distribution.alpha_v()); },
          true),
      number_slot(
          "alpha_v",
          [](auto& model, float alpha) noexcept { model.distribution.set_alpha(model.distribution.alpha_u(), alpha); },
          true)};
}

}  // namespace equaltime
