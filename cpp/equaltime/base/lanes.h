// Lanes: numbers of several paths that take the same steps together. A function that is a template over Real is written
// once: with Real = float it is that of one path, with a pack of floats that of as many paths as the pack has lanes. A
// comparison then gives a mask.
//
// Paths part in three ways. `select` takes one of two values, a lane at a time. `where` computes only what some lane
// asks for. `none` says that no lane goes on.
//
// A pack specialises LaneTraits, and has the operators of float, these functions of masks and the functions of
// math/numeric.h. The core has float alone; cpp/tests/lanes.h has a pack, which holds the templates to this.
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

template <LaneNumber Real>
using Mask = typename LaneTraits<Real>::Mask;
/// A float64 a lane.
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

/// first() in the lanes of the mask, second() in the others, or zero. Each is called only if a lane asks for it, so
/// that no lane divides by 0 for nothing.
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
[[gnu::always_inline]] constexpr std::uint32_t gather(const Table& table, std::uint32_t index) noexcept {
  return table[index];
}

/// f of the numbers of each lane, one lane after the other: for what is rare, or parts too often.
template <LaneNumber Real, class F, class... Args>
[[gnu::always_inline]] inline auto for_each_lane(F&& f, const Args&... args) noexcept {
  if constexpr (LaneTraits<Real>::width == 1)
    return f(args...);
  else
    return LaneTraits<Real>::for_each(f, args...);
}

/// Whether a model is written for lanes: it is a template over Real. Any other takes one path at a time.
template <class Model>
inline constexpr bool kHasLanes = false;
template <template <class> class Model>
inline constexpr bool kHasLanes<Model<float>> = true;

}  // namespace equaltime
