// Lanes: numbers of several paths that take the same steps together. A function that is a template over Real is written
// once: for Real = float it works on one path, for a pack of floats on one path in each lane. Comparisons of packs give
// masks.
//
// Where paths differ, `select` takes one of two values in each lane, and `where` computes only what some lane asks for.
// `none` tells that no lane goes on.
//
// A pack specialises LaneTraits. It has the operators of float, these functions of masks, and the functions of
// math/numeric.h. The core compiles float alone. Tests compare the lanes of a pack (cpp/tests/lanes.h) with single
// paths.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>

namespace equaltime {

/// The types that go with a number of lanes.
template <class Real>
struct LaneTraits {};
template <>
struct LaneTraits<float> {
  static constexpr std::size_t width = 1;
  using Mask = bool;
  using Double = double;
  using Int = std::int32_t;
  using Bits = std::uint32_t;
  using Bits64 = std::uint64_t;
};
template <>
struct LaneTraits<double> : LaneTraits<float> {};

template <class T>
concept LaneNumber = requires {
  LaneTraits<T>::width;
};

/// A truth for each lane.
template <LaneNumber Real>
using Mask = typename LaneTraits<Real>::Mask;
/// A float64 for each lane.
template <LaneNumber Real>
using Double = typename LaneTraits<Real>::Double;
template <LaneNumber Real>
using Int = typename LaneTraits<Real>::Int;
template <LaneNumber Real>
using Bits = typename LaneTraits<Real>::Bits;
template <LaneNumber Real>
using Bits64 = typename LaneTraits<Real>::Bits64;

namespace detail {
/// The mask that tells which lanes have a value of a type: bool, but for numbers of lanes and templates over them.
template <class T>
struct MaskOf {
  using type = bool;
};
template <LaneNumber Real>
struct MaskOf<Real> {
  using type = Mask<Real>;
};
template <template <class> class Value, LaneNumber Real>
requires(!LaneNumber<Value<Real>>) struct MaskOf<Value<Real>> {
  using type = Mask<Real>;
};
}  // namespace detail
template <class T>
using MaskOf = typename detail::MaskOf<T>::type;

constexpr bool any(bool mask) noexcept { return mask; }
constexpr bool none(bool mask) noexcept { return !mask; }

/// first() in the lanes of the mask, and second(), or zero, in the others. A function is called only if some lane asks
/// for it.
template <class First, class Second>
[[gnu::always_inline]] constexpr auto where(bool mask, First&& first, Second&& second) noexcept {
  return mask ? first() : second();
}
template <class First>
[[gnu::always_inline]] constexpr auto where(bool mask, First&& first) noexcept {
  return mask ? first() : decltype(first()){};
}

/// The element of a table, in each lane.
template <class Table>
[[gnu::always_inline]] constexpr std::uint32_t lookup(const Table& table, std::uint32_t index) noexcept {
  return table[index];
}

/// Calls f with the numbers of each lane, one lane after the other: for code that is rare or has many branches.
template <LaneNumber Real, class F, class... Args>
[[gnu::always_inline]] inline auto for_each_lane(F&& f, const Args&... args) noexcept {
  if constexpr (LaneTraits<Real>::width == 1)
    return f(args...);
  else
    return LaneTraits<Real>::for_each(f, args...);
}

/// Whether a model is written for lanes, as a template over Real. Any other model takes one path at a time.
template <class Model>
inline constexpr bool kHasLanes = false;
template <template <class> class Model>
inline constexpr bool kHasLanes<Model<float>> = true;

}  // namespace equaltime
