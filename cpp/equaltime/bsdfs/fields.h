// Fields: the parameters of a model as tables. Bindings, checks and materials go through them, so that none of these
// knows a model by name. A model has two: `fields` of its description, and `textured`, what textures may give it.
#pragma once

#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>

#include "equaltime/math/spectrum.h"
#include "equaltime/math/vector.h"

namespace equaltime {

/// From the least to the most that a number may be, or each channel of a colour.
struct Range {
  double least = 0, most = 0;
};

inline constexpr Range kShare{0, 1};
inline constexpr Range kCoefficient{0, static_cast<double>(std::numeric_limits<float>::max())};
inline constexpr Range kRoughness{static_cast<double>(std::numeric_limits<float>::min()), kCoefficient.most};
/// The range of an index of refraction relative to the outside. Python's readers take indices from 0.001 to 1000 on
/// both sides, whose ratios reach 10^6; far beyond that, float32 loses the light.
inline constexpr Range kIor{1e-6, 1e6};

/// A parameter of a description: a number, a colour, a truth or a microfacet model. The range is of the first two.
template <class Description, class Value>
struct Field {
  const char* name;
  Value Description::*value;
  Range range = {};
};
template <class Description, class Value>
Field(const char*, Value Description::*, Range = {}) -> Field<Description, Value>;  // Clang 14 needs to be told

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

/// Calls f with each element of a table, and with its place there.
template <class Table, class F>
constexpr void for_each_of(const Table& table, F&& f) {
  std::apply(
      [&](const auto&... element) {
        std::size_t place = 0;
        (f(element, place++), ...);
      },
      table);
}

}  // namespace equaltime
