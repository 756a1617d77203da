// Fields: the parameters of a model as a table. Bindings and checks go through it, so that none of these knows a model
// by name.
#pragma once

#include <cstddef>
#include <limits>
#include <tuple>

namespace equaltime {

/// From the least to the most that a number may be, or each channel of a colour; an open range is without both.
struct Range {
  double least = 0, most = 0;
  bool open = false;
};

inline constexpr Range kShare{0, 1};
inline constexpr Range kCoefficient{0, static_cast<double>(std::numeric_limits<float>::max())};
inline constexpr Range kRoughness{static_cast<double>(std::numeric_limits<float>::min()), kCoefficient.most};
/// The range of an index of refraction relative to the outside. Python's readers take indices from 0.001 to 1000 on
/// both sides, whose ratios reach 10^6; far beyond that, float32 loses the light.
inline constexpr Range kIor{1e-6, 1e6};

/// A parameter of a description: a number, a list of numbers, a colour, a truth or a microfacet model. The range is of
/// the first three.
template <class Description, class Value>
struct Field {
  const char* name;
  Value Description::*value;
  Range range = {};
};
template <class Description, class Value>
Field(const char*, Value Description::*, Range = {}) -> Field<Description, Value>;  // Clang 14 needs to be told

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
