// A pack of numbers, as templates over Real take it (base/lanes.h): arrays, worked on lane by lane. It is no fast one.
// It holds the templates to what lanes have, and to the bits of one path.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "equaltime/base/lanes.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/facets.h"
#include "equaltime/lights/flat_light.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/point.h"
#include "equaltime/math/spectrum.h"
#include "equaltime/math/vector.h"
#include "equaltime/sampling/scattering.h"
#include "tests/check.h"

namespace equaltime {

inline constexpr std::size_t kLanes = 4;

template <class T>
struct Pack {
  std::array<T, kLanes> lanes{};

  constexpr Pack() noexcept = default;
  constexpr Pack(T value) noexcept { lanes.fill(value); }
  template <class U>
  constexpr explicit Pack(const Pack<U>& other) noexcept {
    for (std::size_t i = 0; i < kLanes; ++i) lanes[i] = static_cast<T>(other[i]);
  }
  constexpr T& operator[](std::size_t i) noexcept { return lanes[i]; }
  constexpr const T& operator[](std::size_t i) const noexcept { return lanes[i]; }

  /// f of each lane of the packs.
  template <class F, class... Packs>
  static constexpr auto map(F&& f, const Packs&... packs) noexcept {
    Pack<decltype(f(packs[0]...))> out;
    for (std::size_t i = 0; i < kLanes; ++i) out[i] = f(packs[i]...);
    return out;
  }

  constexpr Pack operator-() const noexcept {
    return map([](T x) { return -x; }, *this);
  }
  constexpr Pack operator!() const noexcept {
    return map([](T x) { return !x; }, *this);
  }
#define EQUALTIME_OPERATOR(symbol)                                               \
  friend constexpr auto operator symbol(const Pack& a, const Pack& b) noexcept { \
    return map([](T x, T y) { return x symbol y; }, a, b);                       \
  }
  EQUALTIME_OPERATOR(+)
  EQUALTIME_OPERATOR(-)
  EQUALTIME_OPERATOR(*)
  EQUALTIME_OPERATOR(/)
  EQUALTIME_OPERATOR(&)
  EQUALTIME_OPERATOR(^)
  EQUALTIME_OPERATOR(|)
  EQUALTIME_OPERATOR(%)
  EQUALTIME_OPERATOR(<<)
  EQUALTIME_OPERATOR(>>)
  EQUALTIME_OPERATOR(&&)
  EQUALTIME_OPERATOR(||)
  EQUALTIME_OPERATOR(==)
  EQUALTIME_OPERATOR(!=)
  EQUALTIME_OPERATOR(<)
  EQUALTIME_OPERATOR(<=)
  EQUALTIME_OPERATOR(>)
  EQUALTIME_OPERATOR(>=)
#undef EQUALTIME_OPERATOR

  friend Pack sqrt(const Pack& x) noexcept {
    return map([](T lane) { return std::sqrt(lane); }, x);
  }
  friend Pack abs(const Pack& x) noexcept {
    return map([](T lane) { return std::abs(lane); }, x);
  }
  friend Pack copysign(const Pack& x, const Pack& sign) noexcept {
    return map([](T a, T b) { return std::copysign(a, b); }, x, sign);
  }
  friend constexpr Pack min(const Pack& x, const Pack& y) noexcept {
    return map([](T a, T b) { return std::min(a, b); }, x, y);
  }
  friend constexpr Pack max(const Pack& x, const Pack& y) noexcept {
    return map([](T a, T b) { return std::max(a, b); }, x, y);
  }
};

using Floats = Pack<float>;
using Truths = Pack<bool>;

/// The type of lanes of a value of one path.
template <class T>
struct InLanes {
  using type = Pack<T>;
};
template <template <class> class Value>
struct InLanes<Value<float>> {
  using type = Value<Floats>;
};
template <class T>
using LanesOf = typename InLanes<T>::type;

template <>
struct LaneTraits<Floats> {
  static constexpr std::size_t width = kLanes;
  using Mask = Truths;
  using Double = Pack<double>;
  using Int = Pack<std::int32_t>;
  using Bits = Pack<std::uint32_t>;
  using Bits64 = Pack<std::uint64_t>;

  template <class F, class... Args>
  static auto for_each(F&& f, const Args&... args) noexcept {
    LanesOf<decltype(f(lane(args, 0)...))> out;
    for (std::size_t i = 0; i < kLanes; ++i) set_lane(out, i, f(lane(args, i)...));
    return out;
  }
};
template <>
struct LaneTraits<Pack<double>> : LaneTraits<Floats> {};

// --- Lanes of the structs that functions give ---------------------------------------------------------------------

template <class T>
constexpr const T& lane(const T& same_for_all, std::size_t) noexcept {
  return same_for_all;
}
template <class T>
constexpr T lane(const Pack<T>& x, std::size_t i) noexcept {
  return x[i];
}
template <class T>
constexpr Vec3<T> lane(const Vec3<Pack<T>>& v, std::size_t i) noexcept {
  return {v.x[i], v.y[i], v.z[i]};
}
template <class T>
constexpr Rgb<T> lane(const Rgb<Pack<T>>& s, std::size_t i) noexcept {
  return {s.r[i], s.g[i], s.b[i]};
}
template <class T>
constexpr Point2<T> lane(const Point2<Pack<T>>& p, std::size_t i) noexcept {
  return {p.x[i], p.y[i]};
}
inline FlatEdges<float> lane(const FlatEdges<Floats>& e, std::size_t i) noexcept {
  return {lane(e.corner, i), lane(e.edge_x, i), lane(e.edge_y, i)};
}
inline DrawnPoint<float> lane(const DrawnPoint<Floats>& v, std::size_t i) noexcept {
  return {lane(v.point, i), v.solid_angle[i]};
}

template <class T>
constexpr void set_lane(Pack<T>& x, std::size_t i, T value) noexcept {
  x[i] = value;
}
template <class T>
constexpr void set_lane(Vec3<Pack<T>>& v, std::size_t i, const Vec3<T>& value) noexcept {
  v.x[i] = value.x, v.y[i] = value.y, v.z[i] = value.z;
}
template <class T>
constexpr void set_lane(Point2<Pack<T>>& p, std::size_t i, const Point2<T>& value) noexcept {
  p.x[i] = value.x, p.y[i] = value.y;
}
template <class T>
constexpr void set_lane(Rgb<Pack<T>>& s, std::size_t i, const Rgb<T>& value) noexcept {
  s.r[i] = value.r, s.g[i] = value.g, s.b[i] = value.b;
}
inline void set_lane(DrawnPoint<Floats>& v, std::size_t i, const DrawnPoint<float>& value) noexcept {
  set_lane(v.point, i, value.point), v.solid_angle[i] = value.solid_angle;
}

template <class T>
constexpr Pack<T> select(const Truths& first, const Pack<T>& a, const Pack<T>& b) noexcept {
  return Pack<T>::map([](bool f, T x, T y) { return f ? x : y; }, first, a, b);
}
template <class T>
constexpr Vec3<Pack<T>> select(const Truths& first, const Vec3<Pack<T>>& a, const Vec3<Pack<T>>& b) noexcept {
  return {select(first, a.x, b.x), select(first, a.y, b.y), select(first, a.z, b.z)};
}
template <class T>
constexpr Point2<Pack<T>> select(const Truths& first, const Point2<Pack<T>>& a, const Point2<Pack<T>>& b) noexcept {
  return {select(first, a.x, b.x), select(first, a.y, b.y)};
}
inline FacetLobe<Floats> select(const Truths& first, const FacetLobe<Floats>& a, const FacetLobe<Floats>& b) noexcept {
  return {select(first, a.f_cos, b.f_cos), select(first, a.pdf, b.pdf)};
}
inline BsdfValue<Floats> select(const Truths& first, const BsdfValue<Floats>& a, const BsdfValue<Floats>& b) noexcept {
  return {select(first, a.f_cos, b.f_cos), select(first, a.pdf, b.pdf)};
}
inline BsdfSample<Floats> select(const Truths& first, const BsdfSample<Floats>& a,
                                 const BsdfSample<Floats>& b) noexcept {
  return {select(first, a.wi, b.wi), select(first, a.weight, b.weight), select(first, a.pdf, b.pdf),
          select(first, a.delta, b.delta), select(first, a.eta_scale, b.eta_scale)};
}
template <class T>
Optional<T> select(const Truths& first, const Optional<T>& a, const Optional<T>& b) noexcept {
  return {select(first, *a, *b), select(first, a.has_value(), b.has_value())};
}

template <class Table>
constexpr Pack<std::uint32_t> lookup(const Table& table, const Pack<std::uint32_t>& index) noexcept {
  return Pack<std::uint32_t>::map([&](std::uint32_t i) -> std::uint32_t { return table[i]; }, index);
}

constexpr bool any(const Truths& mask) noexcept {
  return std::ranges::any_of(mask.lanes, [](bool lane) { return lane; });
}
constexpr bool none(const Truths& mask) noexcept { return !any(mask); }

template <class First, class Second>
auto where(const Truths& mask, First&& first, Second&& second) noexcept {
  using Result = decltype(true ? first() : second());
  if (none(mask)) return Result(second());
  if (none(!mask)) return Result(first());
  return select(mask, Result(first()), Result(second()));
}
template <class First>
auto where(const Truths& mask, First&& first) noexcept {
  return where(mask, first, [] { return decltype(first()){}; });
}

// --- Equal bits ---------------------------------------------------------------------------------------------------

inline bool same(float a, float b) { return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b); }
inline bool same(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }
inline bool same(const Spectrum& a, const Spectrum& b) { return same(a.r, b.r) && same(a.g, b.g) && same(a.b, b.b); }
inline bool same(const Vec3f& a, const Vec3f& b) { return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z); }

// --- Lanes against single paths -----------------------------------------------------------------------------------

/// How many lanes differ from the path of the next lane, and how many of these have a value where the path has none, or
/// the other way round. A test asks for enough of both, or it would not see lanes that are mixed up.
struct NextLane {
  int differs = 0, parts = 0;
};

/// Checks that each lane of a result has the bits of one path, over packs of random cases. `random_case` draws the case
/// of one path. `result` computes the result of a case, for lanes or for one path. A result has
/// `has_value`. `agrees(wide, i, one)` compares lane i of a result for lanes with the result of one path.
template <template <class> class Case, class RandomCase, class Result>
NextLane check_lanes(int packs, RandomCase&& random_case, Result&& result) {
  NextLane next_lane;
  for (int k = 0; k < packs; ++k) {
    std::array<Case<float>, kLanes> cases;
    Case<Floats> all{};
    for (std::size_t i = 0; i < kLanes; ++i) set_lane(all, i, cases[i] = random_case());
    const auto wide = result(all);
    for (std::size_t i = 0; i < kLanes; ++i) {
      const auto one = result(cases[i]), next = result(cases[(i + 1) % kLanes]);
      CHECK(agrees(wide, i, one));
      next_lane.differs += !agrees(wide, i, next);
      next_lane.parts += one.has_value != next.has_value;
    }
  }
  return next_lane;
}

}  // namespace equaltime
