// Sampler: the random numbers of one path, a pure function of (seed, pixel, sample index, slot).
// No state moves: numbers may be asked for in any order, any number of times, on any thread.
//
// `sobol` gives each slot the 2-D Sobol' points with nested uniform (Owen) scrambling and an Owen-shuffled index, so
// that slots are padded without correlation (Burley 2020). Each net of a pixel's samples is scrambled on its own: the
// difference of two makes an honest error bar possible. `stratified` gives it jittered strata in the same way
// (sampling/stratified.h). `lattice` takes the slots of the first vertices from one lattice (sampling/lattice.h) and
// pads the others. `independent` hashes the sample index instead.
#pragma once

#include <cstdint>

#include "equaltime/base/bits.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/point.h"
#include "equaltime/sampling/dimensions.h"
#include "equaltime/sampling/lattice.h"
#include "equaltime/sampling/sobol.h"
#include "equaltime/sampling/stratified.h"

namespace equaltime {

enum class SamplerKind : std::uint8_t { independent, stratified, sobol, lattice };

/// The numbers that a vertex with a continuous BSDF uses: what get_2d gives for the two slots, made together.
struct VertexNumbers {
  Point2f light_point, bsdf_direction;
};

class Sampler {
 public:
  /// `pixel` is the pixel's place in the full film, so that a crop has the numbers of the whole. Sample `index` belongs
  /// to net `index mod nets`. Those from 2^32 `nets` on are samples of further nets.
  [[nodiscard]] static Sampler at(SamplerKind kind, std::uint64_t seed, std::uint64_t pixel, std::uint64_t index,
                                  std::uint32_t nets) noexcept {
    const std::uint64_t stream = mix64(mix64(seed + kGolden) + pixel * kGolden);
    if (kind == SamplerKind::independent) return {kind, mix64(stream + index * kGolden), 0};
    const std::uint64_t in_net = index / nets, net = index % nets + (in_net >> 32U) * nets;
    return {kind, mix64(stream + (net + 1) * kGolden), reverse_bits(static_cast<std::uint32_t>(in_net))};
  }

  /// The numbers of one of the 2^log2_copies that a path becomes: together those of as many more samples.
  [[nodiscard]] Sampler copy(std::uint32_t number, std::uint32_t log2_copies) const noexcept {
    const std::uint64_t family = key_ + (kCopies + log2_copies) * kGolden;
    if (kind_ == SamplerKind::independent) return {kind_, mix64(family + mix64(number + 1)), 0};
    const std::uint32_t lost = reversed_index_ & ((1U << log2_copies) - 1);  // the leading bits of the index
    return {kind_, mix64(family + lost), (reversed_index_ >> log2_copies) | reverse_bits(number)};
  }

  /// One number in [0, 1), a multiple of 2^-24.
  [[nodiscard]] EQUALTIME_INLINE float get_1d(Slot s) const noexcept {
    return unit_float(static_cast<std::uint32_t>(bits(s) >> 32));
  }

  /// One number in [0, 1) of 53 bits, for probabilities far below 2^-24.
  [[nodiscard]] double get_1d_precise(Slot s) const noexcept { return static_cast<double>(bits(s) >> 11) * 0x1p-53; }

  /// One number of 64 bits, for choices whose probabilities reach below 2^-24: the leading 32 are stratified.
  [[nodiscard]] EQUALTIME_INLINE std::uint64_t bits(Slot s) const noexcept {
    const std::uint64_t h = hash(s);
    if (kind_ != SamplerKind::lattice || !lattice::has(s)) [[unlikely]]
      return other_bits(kind_, reversed_index_, h);
    const std::uint32_t x = lattice::coordinate(reversed_index_, s, 0, sobol::seed_x(h));
    return (static_cast<std::uint64_t>(x) << 32) | low_bits(reversed_index_, h);
  }

  /// Two numbers in [0, 1), multiples of 2^-24, jointly stratified.
  [[nodiscard]] EQUALTIME_INLINE Point2f get_2d(Slot s) const noexcept {
    const Bits2 p = bits_2d(s, hash(s));
    return {unit_float(p.x), unit_float(p.y)};
  }

  [[nodiscard]] EQUALTIME_INLINE VertexNumbers vertex(std::uint32_t bounce) const noexcept {
    const Slot light = slot(BounceDimension::light_point, bounce), bsdf = slot(BounceDimension::bsdf_direction, bounce);
    const std::uint64_t a = hash(light), b = hash(bsdf);
    const sobol::FloatLanes p =
        sobol::unit_floats(kind_ == SamplerKind::sobol ? two_sobol_points(reversed_index_, a, b)
                                                       : lanes(bits_2d(light, a), bits_2d(bsdf, b)));
    return {{p[0], p[1]}, {p[2], p[3]}};
  }

  /// As get_2d with the same leading bits, continued to 53 bits by hashing: for tables of very uneven probabilities.
  [[nodiscard]] Point2d get_2d_precise(Slot s) const noexcept {
    const std::uint64_t h = hash(s);
    const Bits2 p = bits_2d(s, h);
    const std::uint64_t low = mix64(h + reversed_index_ + kGolden);
    return {static_cast<double>(((static_cast<std::uint64_t>(p.x) << 32) | (low >> 32)) >> 11) * 0x1p-53,
            static_cast<double>(((static_cast<std::uint64_t>(p.y) << 32) | (low & 0xffffffffU)) >> 11) * 0x1p-53};
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
  static constexpr std::uint64_t kCopies = std::uint64_t{1} << 40;  // beyond all slots
  struct Bits2 {
    std::uint32_t x, y;
  };

  Sampler(SamplerKind kind, std::uint64_t key, std::uint32_t reversed_index) noexcept
      : key_(key), reversed_index_(reversed_index), kind_(kind) {}

  [[nodiscard]] EQUALTIME_INLINE std::uint64_t hash(Slot s) const noexcept {
    return mix64(key_ + (s.index + 1) * kGolden);
  }

  [[nodiscard]] EQUALTIME_INLINE Bits2 bits_2d(Slot s, std::uint64_t h) const noexcept {
    if (kind_ != SamplerKind::lattice || !lattice::has(s)) [[unlikely]]
      return other_bits_2d(kind_, reversed_index_, h);
    return {lattice::coordinate(reversed_index_, s, 0, sobol::seed_x(h)),
            lattice::coordinate(reversed_index_, s, 1, sobol::seed_y(h))};
  }
  [[nodiscard]] EQUALTIME_INLINE static sobol::Lanes lanes(Bits2 a, Bits2 b) noexcept {
    return sobol::Lanes{a.x, a.y, b.x, b.y};
  }

  [[nodiscard]] static std::uint32_t low_bits(std::uint32_t reversed_index, std::uint64_t h) noexcept {
    return static_cast<std::uint32_t>(mix64(h + reversed_index) >> 32);
  }

  // The other kinds, and slots that the lattice lacks, are out of line and get values: inlined, they would slow down
  // paths that take points of the lattice.
  [[nodiscard, gnu::noinline]] static std::uint64_t other_bits(SamplerKind kind, std::uint32_t reversed_index,
                                                               std::uint64_t h) noexcept {
    if (kind == SamplerKind::independent) return h;
    const std::uint32_t index = padded(kind, reversed_index, h);
    const std::uint32_t shuffled = reverse_bits(sobol::scramble_reversed(index, sobol::seed_shuffle(h)));
    const std::uint32_t x = sobol::scramble_reversed(shuffled, sobol::seed_x(h));
    return (static_cast<std::uint64_t>(reverse_bits(x)) << 32) | low_bits(index, h);
  }
  [[nodiscard, gnu::noinline]] static Bits2 other_bits_2d(SamplerKind kind, std::uint32_t reversed_index,
                                                          std::uint64_t h) noexcept {
    if (kind == SamplerKind::sobol || kind == SamplerKind::lattice) {
      const sobol::Lanes p = sobol::two_points(padded(kind, reversed_index, h), h, h);
      return {p[0], p[1]};
    }
    const std::uint64_t both = kind == SamplerKind::independent ? h : stratified::bits_2d(reversed_index, h);
    return {static_cast<std::uint32_t>(both >> 32), static_cast<std::uint32_t>(both)};
  }
  [[nodiscard, gnu::noinline]] static sobol::Lanes two_sobol_points(std::uint32_t reversed_index, std::uint64_t a,
                                                                    std::uint64_t b) noexcept {
    return sobol::two_points(reversed_index, a, b);
  }
  [[nodiscard]] static std::uint32_t padded(SamplerKind kind, std::uint32_t reversed_index, std::uint64_t h) noexcept {
    return kind == SamplerKind::lattice ? lattice::padded_index(reversed_index, h) : reversed_index;
  }

  std::uint64_t key_;
  std::uint32_t reversed_index_;
  SamplerKind kind_;
};

}  // namespace equaltime
