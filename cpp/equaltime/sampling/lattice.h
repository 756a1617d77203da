// One rank-1 lattice for all dimensions of a path, in van der Corput order. Point i has the coordinate i' z / 2^32 +
// shift modulo 1: i' is the bit-reversed index, and z is the dimension's component of the vector. Points m·2^k to
// (m + 1)·2^k - 1 are a shifted lattice, for all m and k. Each pixel and slot has a random shift of its own.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>

#include "equaltime/base/bits.h"
#include "equaltime/sampling/lattice_vector.h"

namespace equaltime::lattice {

/// The vector's components, from index 1 on. Index 0 holds a 0 for slots without dimensions.
inline constexpr auto kComponents = [] {
  std::array<std::uint32_t, std::size(kVector) + 1> components{};
  std::copy(std::begin(kVector), std::end(kVector), components.begin() + 1);
  return components;
}();

/// A coordinate of a point, in 32 bits: `dimension` counts from 1.
template <class Real>
[[nodiscard]] constexpr Bits<Real> coordinate(Bits<Real> reversed_index, Bits<Real> dimension,
                                              Bits<Real> shift) noexcept {
  return reversed_index * lookup(kComponents, dimension) + shift;
}

}  // namespace equaltime::lattice
