// Sampler: the random numbers of one path, a pure function of (seed, pixel, sample index, slot).
// No state moves: numbers may be asked for in any order, any number of times, on any thread.
//
// `lattice` and `sobol` take the slots of the first vertices from one point in many dimensions
// (sampling/dimensions.h): of a shifted rank-1 lattice, or of a Sobol' sequence with nested uniform (Owen) scrambling.
// They pad the other slots with 2-D Sobol' points, each in an order of its own, so that slots are not correlated
// (Burley 2020). `stratified` gives all slots jittered strata in that way (sampling/stratified.h). Each net of a
// pixel's samples has shifts, scrambles and orders of its own: the difference of two makes an honest error bar
// possible. `independent` hashes the sample index.
#pragma once

#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/point.h"
#include "equaltime/sampling/decisions.h"
#include "equaltime/sampling/dimensions.h"
#include "equaltime/sampling/lattice.h"
#include "equaltime/sampling/sobol.h"
#include "equaltime/sampling/stratified.h"

namespace equaltime {

/// Four numbers worked on together (a vector extension of GCC and Clang, SSE on x86).
using FourBits = std::uint32_t __attribute__((vector_size(16)));
using FourFloats = float __attribute__((vector_size(16)));

/// unit_float of each.
EQUALTIME_INLINE FourFloats unit_floats(FourBits x) noexcept {
  using Ints = std::int32_t __attribute__((vector_size(16)));
  return __builtin_convertvector(reinterpret_cast<Ints>(x >> 8), FourFloats) * 0x1p-24F;
}

enum class SamplerKind : std::uint8_t { independent, stratified, sobol, lattice };

/// The numbers that a vertex with a continuous BSDF uses: what get_2d gives for the two slots, made together.
template <class Real>
struct BasicVertexNumbers {
  Point2<Real> light_point, bsdf_direction;
};
using VertexNumbers = BasicVertexNumbers<float>;

/// All lanes have one SamplerKind.
template <LaneNumber Real>
class BasicSampler {
  using U32 = Bits<Real>;
  using U64 = Bits64<Real>;

 public:
  using Slot = BasicSlot<Real>;

  /// `pixel` is the pixel's place in the full film, so that a crop has the numbers of the whole. Sample `index` belongs
  /// to net `index mod nets`. A net has 2^32 samples: indices from 2^32 · `nets` on begin further nets.
  [[nodiscard]] static BasicSampler at(SamplerKind kind, std::uint64_t seed, U64 pixel, U64 index,
                                       std::uint32_t nets) noexcept {
    const U64 stream = mix64<U64>(mix64(seed + kGolden) + pixel * kGolden);
    if (kind == SamplerKind::independent) return {kind, mix64<U64>(stream + index * kGolden), 0};
    const U64 in_net = index / nets, net = index % nets + (in_net >> 32) * nets;
    return {kind, mix64<U64>(stream + (net + 1) * kGolden), reverse_bits<U32>(U32(in_net))};
  }

  /// The sampler of one of the 2^k copies of a split path, k = log2_copies. Each k has a point set of its own. Copy c
  /// of sample i takes its point i·2^k + c, so that the copies of the first n samples have its first n·2^k points.
  [[nodiscard]] BasicSampler copy(std::uint32_t number, std::uint32_t log2_copies) const noexcept {
    const U64 family = key_ + (kCopyStreams + log2_copies) * kGolden;
    if (kind_ == SamplerKind::independent) return {kind_, mix64<U64>(family + mix64(number + 1)), 0};
    const U32 leading_bits = reversed_index_ & ((1U << log2_copies) - 1);  // of the index, which the shift loses
    return {kind_, mix64<U64>(family + U64(leading_bits)), (reversed_index_ >> log2_copies) | reverse_bits(number)};
  }

  /// One number in [0, 1), a multiple of 2^-24.
  [[nodiscard]] EQUALTIME_INLINE Real get_1d(Slot s) const noexcept { return unit_float<Real>(U32(bits(s) >> 32)); }

  /// One number in [0, 1) of 53 bits, for probabilities far below 2^-24.
  [[nodiscard]] Double<Real> get_1d_precise(Slot s) const noexcept { return Double<Real>(bits(s) >> 11) * 0x1p-53; }

  /// One number of 64 bits, for choices whose probabilities reach below 2^-24: the leading 32 are stratified.
  [[nodiscard]] EQUALTIME_INLINE U64 bits(Slot s) const noexcept {
    const U64 h = hash(s);
    const U32 dimension = lattice_dimension(s);
    const Mask<Real> in_lattice = dimension != 0;
    const auto outside_lattice = [&]() noexcept {
      return for_each_lane<Real>(other_bits, kind_, reversed_index_, s.index, h);
    };
    if (none(in_lattice)) [[unlikely]]
      return outside_lattice();
    const U32 x = lattice::coordinate<Real>(reversed_index_, dimension, seed_x<Real>(h));
    const U64 point = (U64(x) << 32) | U64(low_bits<Real>(reversed_index_, h));
    return where(
        in_lattice, [&]() noexcept { return point; }, outside_lattice);
  }

  /// Two numbers in [0, 1), multiples of 2^-24, jointly stratified.
  [[nodiscard]] EQUALTIME_INLINE Point2<Real> get_2d(Slot s) const noexcept {
    const Fractions2 p = fractions_2d(s, hash(s));
    return {unit_float<Real>(p.x), unit_float<Real>(p.y)};
  }

  [[nodiscard]] EQUALTIME_INLINE BasicVertexNumbers<Real> vertex(U32 bounce) const noexcept {
    const Slot light = slot<Real>(BounceDecision::light_point, bounce);
    const Slot bsdf = slot<Real>(BounceDecision::bsdf_direction, bounce);
    if constexpr (LaneTraits<Real>::width == 1) {  // four numbers of one path are made floats together
      const Fractions2 a = fractions_2d(light, hash(light)), b = fractions_2d(bsdf, hash(bsdf));
      const FourFloats p = unit_floats(FourBits{a.x, a.y, b.x, b.y});
      return {{p[0], p[1]}, {p[2], p[3]}};
    }
    return {get_2d(light), get_2d(bsdf)};
  }

  /// As get_2d with the same leading bits, continued to 53 bits by hashing: for tables of very uneven probabilities.
  [[nodiscard]] Point2<Double<Real>> get_2d_precise(Slot s) const noexcept {
    const U64 h = hash(s);
    const Fractions2 p = fractions_2d(s, h);
    const U64 low = mix64<U64>(h + U64(reversed_index_) + kGolden);
    return {Double<Real>(((U64(p.x) << 32) | (low >> 32)) >> 11) * 0x1p-53,
            Double<Real>(((U64(p.y) << 32) | (low & 0xffffffffU)) >> 11) * 0x1p-53};
  }

 private:
  static constexpr std::uint64_t kCopyStreams = std::uint64_t{1} << 40;  // beyond all slots
  using Fractions2 = Point2<U32>;                                        // in units of 2^-32

  BasicSampler(SamplerKind kind, U64 key, U32 reversed_index) noexcept
      : key_(key), reversed_index_(reversed_index), kind_(kind) {}

  [[nodiscard]] EQUALTIME_INLINE U64 hash(Slot s) const noexcept {
    return mix64<U64>(key_ + U64(s.index + 1) * kGolden);
  }
  /// The first dimension of a slot in the lattice. Dimensions count from 1; 0: the slot has none.
  [[nodiscard]] EQUALTIME_INLINE U32 lattice_dimension(Slot s) const noexcept {
    if (kind_ != SamplerKind::lattice) [[unlikely]]
      return 0;
    return first_dimension<Real>(s);
  }

  [[nodiscard]] EQUALTIME_INLINE Fractions2 fractions_2d(Slot s, U64 h) const noexcept {
    const U32 dimension = lattice_dimension(s);
    const Mask<Real> in_lattice = dimension != 0;
    const auto outside_lattice = [&]() noexcept {
      const U64 both = for_each_lane<Real>(other_fractions_2d, kind_, reversed_index_, s.index, h);
      return Fractions2{U32(both >> 32), U32(both)};
    };
    if (none(in_lattice)) [[unlikely]]
      return outside_lattice();
    const Fractions2 point{lattice::coordinate<Real>(reversed_index_, dimension, seed_x<Real>(h)),
                           lattice::coordinate<Real>(reversed_index_, dimension + 1, seed_y<Real>(h))};
    return where(
        in_lattice, [&]() noexcept { return point; }, outside_lattice);
  }

  template <class R>
  [[nodiscard]] static Bits<R> low_bits(Bits<R> reversed_index, Bits64<R> h) noexcept {
    return Bits<R>(mix64<Bits64<R>>(h + Bits64<R>(reversed_index)) >> 32);
  }

  // Numbers of other kinds, and of slots that the lattice lacks, are made out of line, from values, lane by lane:
  // inlined, they would slow down paths that take points of the lattice.
  [[nodiscard, gnu::noinline]] static std::uint64_t other_bits(SamplerKind kind, std::uint32_t reversed_index,
                                                               std::uint32_t slot, std::uint64_t h) noexcept {
    if (kind == SamplerKind::independent) return h;
    const auto with_low = [h](std::uint32_t x, std::uint32_t place) {
      return (static_cast<std::uint64_t>(x) << 32) | low_bits<float>(place, h);
    };
    if (const std::uint32_t dimension = sobol_dimension(kind, slot); dimension != 0)
      return with_low(sobol::coordinate(reversed_index, dimension, seed_x(h)), reversed_index);
    const std::uint32_t place =
        kind == SamplerKind::stratified ? reversed_index : sobol::permute_in_16(reversed_index, h);
    return with_low(sobol::padded_x(sobol::shuffled_index(place, h), h), place);
  }
  /// Two fractions of 32 bits, x in the upper half.
  [[nodiscard, gnu::noinline]] static std::uint64_t other_fractions_2d(SamplerKind kind, std::uint32_t reversed_index,
                                                                       std::uint32_t slot, std::uint64_t h) noexcept {
    if (kind == SamplerKind::independent) return h;
    if (kind == SamplerKind::stratified) return stratified::bits_2d(reversed_index, h);
    const auto both = [](std::uint32_t x, std::uint32_t y) { return (static_cast<std::uint64_t>(x) << 32) | y; };
    if (const std::uint32_t dimension = sobol_dimension(kind, slot); dimension != 0)
      return both(sobol::coordinate(reversed_index, dimension, seed_x(h)),
                  sobol::coordinate(reversed_index, dimension + 1, seed_y(h)));
    const std::uint32_t index = sobol::shuffled_index(sobol::permute_in_16(reversed_index, h), h);
    return both(sobol::padded_x(index, h), sobol::padded_y(index, h));
  }
  /// The first dimension of a slot in the Sobol' sequence, or 0.
  [[nodiscard]] static std::uint32_t sobol_dimension(SamplerKind kind, std::uint32_t slot) noexcept {
    return kind == SamplerKind::sobol ? first_dimension(equaltime::Slot{slot}) : 0;
  }

  U64 key_;
  U32 reversed_index_;
  SamplerKind kind_;
};

using Sampler = BasicSampler<float>;

}  // namespace equaltime
