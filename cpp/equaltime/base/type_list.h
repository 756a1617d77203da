// TypeList: a closed set of models, and the one dispatch over it. What a kernel's effects leave out costs nothing.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include "equaltime/base/effects.h"

namespace equaltime {

/// Models of one kind. Each may say by `needs` which effect it is part of; every kernel has the first, and the others
/// that need none. Each has a name.
template <class First, class... Others>
struct TypeList {
  using Variant = std::variant<First, Others...>;
  /// A list of each model.
  using Lists = std::tuple<std::vector<First>, std::vector<Others>...>;
  /// The list with one more model at its end.
  template <class Model>
  using With = TypeList<First, Others..., Model>;
  static constexpr std::size_t size = 1 + sizeof...(Others);
  static constexpr std::array<const char*, size> names{First::name, Others::name...};

  /// Calls f with std::type_identity of each model, in the order of the list.
  template <class F>
  static constexpr void for_each(F&& f) {
    f(std::type_identity<First>{});
    (f(std::type_identity<Others>{}), ...);
  }

  /// The place of a model in the list.
  template <class Model>
  static constexpr std::size_t place_of = [] {
    constexpr bool is_model[] = {std::is_same_v<Model, First>, std::is_same_v<Model, Others>...};
    std::size_t place = 0;
    while (!is_model[place]) ++place;
    return place;
  }();

  /// Calls f with std::type_identity of the model at a place.
  template <class F>
  [[gnu::always_inline]] static inline decltype(auto) at(std::size_t place, F&& f) noexcept {
    return from<0>(place, f);
  }

 private:
  template <std::size_t I, class F>
  [[gnu::always_inline]] static inline decltype(auto) from(std::size_t place, F&& f) noexcept {
    if constexpr (I + 1 < size)
      if (place != I) return from<I + 1>(place, f);
    assert(place == I);
    return f(std::type_identity<std::variant_alternative_t<I, Variant>>{});
  }
};

namespace detail {

/// Whether a kernel for the effects can meet a model.
template <Effects E, class Model>
[[nodiscard]] consteval bool has() noexcept {
  if constexpr (requires { Model::needs; })
    return E.*Model::needs;
  else
    return true;
}

/// The model that `v` is known to hold. Flattened, or compilers call a function for it where much is inlined.
template <std::size_t I, class... Models>
[[nodiscard, gnu::always_inline, gnu::flatten]] inline const auto& held(const std::variant<Models...>& v) noexcept {
  assert(v.index() == I);
  return *std::get_if<I>(&v);
}

template <Effects E, std::size_t I, class... Models, class F>
[[gnu::always_inline]] inline decltype(auto) visit_from(const std::variant<Models...>& v, F&& f) noexcept {
  if constexpr (I == sizeof...(Models)) {
    return f(held<0>(v));
  } else {
    if constexpr (has<E, std::variant_alternative_t<I, std::variant<Models...>>>())
      if (v.index() == I) return f(held<I>(v));
    return visit_from<E, I + 1>(v, f);
  }
}

}  // namespace detail

/// Calls f with the model that `v` holds, of those that a kernel for the effects can meet.
template <Effects E, class... Models, class F>
[[gnu::always_inline]] inline decltype(auto) visit(const std::variant<Models...>& v, F&& f) noexcept {
  return detail::visit_from<E, 1>(v, f);
}

}  // namespace equaltime
