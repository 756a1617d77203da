// The direction numbers of the Sobol' sequence, in all dimensions of a path: made at compile time.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/sampling/dimensions.h"

namespace equaltime::sobol {

/// A dimension after the first: its primitive polynomial modulo 2, as bits from the leading one on, and the first
/// numbers of its recurrence (Joe and Kuo 2008, "Constructing Sobol sequences with better two-dimensional projections",
/// their file new-joe-kuo-6.21201).
struct Recurrence {
  std::uint32_t polynomial;
  std::array<std::uint16_t, 9> first;
};
inline constexpr Recurrence kRecurrences[kDimensions - 1] = {
    {3, {1}},
    {7, {1, 3}},
    {11, {1, 3, 1}},
    {13, {1, 1, 1}},
    {19, {1, 1, 3, 3}},
    {25, {1, 3, 5, 13}},
    {37, {1, 1, 5, 5, 17}},
    {41, {1, 1, 5, 5, 5}},
    {47, {1, 1, 7, 11, 19}},
    {55, {1, 1, 5, 1, 1}},
    {59, {1, 1, 1, 3, 11}},
    {61, {1, 3, 5, 5, 31}},
    {67, {1, 3, 3, 9, 7, 49}},
    {91, {1, 1, 1, 15, 21, 21}},
    {97, {1, 3, 1, 13, 27, 49}},
    {103, {1, 1, 1, 15, 7, 5}},
    {109, {1, 3, 1, 15, 13, 25}},
    {115, {1, 1, 5, 5, 19, 61}},
    {131, {1, 3, 7, 11, 23, 15, 103}},
    {137, {1, 3, 7, 13, 13, 15, 69}},
    {143, {1, 1, 3, 13, 7, 35, 63}},
    {145, {1, 3, 5, 9, 1, 25, 53}},
    {157, {1, 3, 1, 13, 9, 35, 107}},
    {167, {1, 3, 1, 5, 27, 61, 31}},
    {171, {1, 1, 5, 11, 19, 41, 61}},
    {185, {1, 3, 5, 3, 3, 13, 69}},
    {191, {1, 1, 7, 13, 1, 19, 1}},
    {193, {1, 3, 7, 5, 13, 19, 59}},
    {203, {1, 1, 3, 9, 25, 29, 41}},
    {211, {1, 3, 5, 13, 23, 1, 55}},
    {213, {1, 3, 7, 3, 13, 59, 17}},
    {229, {1, 3, 1, 3, 5, 53, 69}},
    {239, {1, 1, 5, 5, 23, 33, 13}},
    {241, {1, 1, 7, 7, 1, 61, 123}},
    {247, {1, 1, 7, 9, 13, 61, 49}},
    {253, {1, 3, 3, 5, 3, 55, 33}},
    {285, {1, 3, 1, 15, 31, 13, 49, 245}},
    {299, {1, 3, 5, 15, 31, 59, 63, 97}},
    {301, {1, 3, 1, 11, 11, 11, 77, 249}},
    {333, {1, 3, 1, 11, 27, 43, 71, 9}},
    {351, {1, 1, 7, 15, 21, 11, 81, 45}},
    {355, {1, 3, 7, 3, 25, 31, 65, 79}},
    {357, {1, 3, 1, 1, 19, 11, 3, 205}},
    {361, {1, 1, 5, 9, 19, 21, 29, 157}},
    {369, {1, 3, 7, 11, 1, 33, 89, 185}},
    {391, {1, 3, 3, 3, 15, 9, 79, 71}},
    {397, {1, 3, 7, 11, 15, 39, 119, 27}},
    {425, {1, 1, 3, 1, 11, 31, 97, 225}},
    {451, {1, 1, 1, 3, 23, 43, 57, 177}},
    {463, {1, 3, 7, 7, 17, 17, 37, 71}},
    {487, {1, 3, 1, 5, 27, 63, 123, 213}},
    {501, {1, 1, 3, 5, 11, 43, 53, 133}},
    {529, {1, 3, 5, 5, 29, 17, 47, 173, 479}},
    {539, {1, 3, 3, 11, 3, 1, 109, 9, 69}},
    {545, {1, 1, 1, 5, 17, 39, 23, 5, 343}},
    {557, {1, 3, 1, 5, 25, 15, 31, 103, 499}},
    {563, {1, 1, 1, 11, 11, 17, 63, 105, 183}},
    {601, {1, 1, 5, 11, 9, 29, 97, 231, 363}},
    {607, {1, 1, 5, 15, 19, 45, 41, 7, 383}},
    {617, {1, 3, 7, 7, 31, 19, 83, 137, 221}},
};

/// The direction numbers of a dimension, for each bit of a bit-reversed index: bit-reversed fractions.
constexpr std::array<std::uint32_t, 32> reversed_directions(std::uint32_t polynomial,
                                                            const std::uint16_t* first) noexcept {
  std::array<std::uint32_t, 32> reversed{};
  std::uint32_t m[32] = {};
  const int degree = static_cast<int>(std::bit_width(polynomial)) - 1;
  for (int i = 0; i < 32; ++i) {
    if (i < degree) {
      m[i] = first[i];
    } else {
      m[i] = m[i - degree];
      for (int k = 1; k <= degree; ++k)
        if (((polynomial >> (degree - k)) & 1U) != 0) m[i] ^= m[i - k] << k;
    }
    reversed[static_cast<std::size_t>(31 - i)] = reverse_bits(m[i] << (31 - i));
  }
  return reversed;
}

/// The direction numbers of each dimension of a path. The first is the radical inverse.
inline constexpr auto kReversedDirections = [] {
  std::array<std::array<std::uint32_t, 32>, kDimensions> all{};
  for (std::uint32_t bit = 0; bit < 32; ++bit) all[0][bit] = 1U << (31 - bit);
  for (std::size_t d = 1; d < kDimensions; ++d)
    all[d] = reversed_directions(kRecurrences[d - 1].polynomial, kRecurrences[d - 1].first.data());
  return all;
}();

}  // namespace equaltime::sobol
