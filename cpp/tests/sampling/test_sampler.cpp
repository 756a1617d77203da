// Random numbers: range, independence of order, stratification, and independence between slots, pixels and replicates.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "equaltime/sampling/sampler.h"
#include "tests/check.h"
#include "tests/statistics.h"

namespace {

using namespace equaltime;

constexpr SamplerKind kKinds[] = {SamplerKind::independent, SamplerKind::stratified, SamplerKind::sobol,
                                  SamplerKind::lattice};

bool is_unit_number(float x) { return x >= 0 && x < 1 && x * 0x1p24F == std::floor(x * 0x1p24F); }

std::vector<Slot> some_slots() {
  std::vector<Slot> slots = {slot(CameraDecision::pixel), slot(CameraDecision::lens)};
  for (const std::uint32_t bounce : {0U, 1U, 7U, 1000U})
    for (const BounceDecision d :
         {BounceDecision::light_point, BounceDecision::bsdf_direction, BounceDecision::roulette})
      slots.push_back(slot(d, bounce));
  return slots;
}

TEST("every number is a multiple of 2^-24 in [0, 1)") {
  for (const SamplerKind kind : kKinds)
    for (std::uint64_t index = 0; index < 20000; ++index) {
      const Sampler s = Sampler::at(kind, 3, index % 100, index * 977, 2);
      const Point2f p = s.get_2d(slot(CameraDecision::pixel));
      CHECK(is_unit_number(p.x) && is_unit_number(p.y));
      CHECK(is_unit_number(s.get_1d(slot(BounceDecision::roulette, 5))));
    }
}

TEST("a vertex's numbers are those of its slots") {
  for (const SamplerKind kind : kKinds)
    for (std::uint64_t index = 0; index < 5000; ++index) {
      const Sampler s = Sampler::at(kind, 1, 12345, index, 3);
      for (const std::uint32_t bounce : {0U, 1U, 63U}) {
        const VertexNumbers v = s.vertex(bounce);
        const Point2f light = s.get_2d(slot(BounceDecision::light_point, bounce));
        const Point2f bsdf = s.get_2d(slot(BounceDecision::bsdf_direction, bounce));
        CHECK(v.light_point.x == light.x && v.light_point.y == light.y);
        CHECK(v.bsdf_direction.x == bsdf.x && v.bsdf_direction.y == bsdf.y);
      }
    }
}

TEST("precise numbers continue the ordinary ones") {
  for (const SamplerKind kind : kKinds)
    for (std::uint64_t index = 0; index < 5000; ++index) {
      const Sampler s = Sampler::at(kind, 9, 4, index, 2);
      const Point2d precise = s.get_2d_precise(slot(BounceDecision::light_point, 0));
      const Point2f p = s.get_2d(slot(BounceDecision::light_point, 0));
      CHECK(std::floor(precise.x * 0x1p24) * 0x1p-24 == static_cast<double>(p.x));
      CHECK(std::floor(precise.y * 0x1p24) * 0x1p-24 == static_cast<double>(p.y));
      CHECK(precise.x < 1 && precise.y < 1);
    }
}

TEST("numbers do not depend on the order in which they are asked for") {
  const std::vector<Slot> slots = some_slots();
  std::vector<std::pair<std::uint64_t, std::size_t>> asked;
  for (std::uint64_t index = 0; index < 64; ++index)
    for (std::size_t k = 0; k < slots.size(); ++k) asked.emplace_back(index, k);
  for (const SamplerKind kind : kKinds) {
    const auto number = [&](const auto& what) {
      const Point2f p = Sampler::at(kind, 7, 99, what.first, 2).get_2d(slots[what.second]);
      return std::pair(p.x, p.y);
    };
    std::vector<std::pair<float, float>> in_order;
    for (const auto& what : asked) in_order.push_back(number(what));
    std::vector<std::size_t> order(asked.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), std::mt19937(1));
    for (const std::size_t i : order) CHECK(number(asked[i]) == in_order[i]);
  }
}

// Whether every elementary interval of area 2^-k holds exactly one of 2^k points: a (0, k, 2)-net in base 2.
bool is_net(const std::vector<Point2f>& points, int k) {
  for (int a = 0; a <= k; ++a) {
    std::vector<bool> taken(points.size(), false);
    for (const Point2f& p : points) {
      const auto column = static_cast<std::size_t>(std::ldexp(p.x, a));
      const auto row = static_cast<std::size_t>(std::ldexp(p.y, k - a));
      const std::size_t cell = (column << (k - a)) | row;
      if (taken[cell]) return false;
      taken[cell] = true;
    }
  }
  return true;
}

std::vector<Point2f> replicate_points(SamplerKind kind, Slot s, std::uint64_t pixel, std::uint32_t replicate,
                                      std::uint32_t replicates, int k) {
  std::vector<Point2f> points;
  for (std::uint64_t j = 0; j < (1ULL << k); ++j)
    points.push_back(Sampler::at(kind, 11, pixel, j * replicates + replicate, replicates).get_2d(s));
  return points;
}

// A slot without dimensions; single samples are padded in sixteens.
constexpr Slot kPadded = slot(BounceDecision::bsdf_direction, 1000);
constexpr int kLeastPadded = 4;

TEST("the first 2^k Sobol' points of the pixel are a (0, k, 2)-net in each replicate, and padded ones from 16 on") {
  for (const std::uint32_t replicates : {1U, 2U, 3U})
    for (std::uint32_t r = 0; r < replicates; ++r)
      for (int k = 0; k <= 10; ++k) {
        const auto points = [&](Slot s) { return replicate_points(SamplerKind::sobol, s, 1000 + r, r, replicates, k); };
        CHECK(is_net(points(slot(CameraDecision::pixel)), k));
        CHECK(k < kLeastPadded || is_net(points(kPadded), k));
      }
}

TEST("the net test rejects independent points, and Sobol points of which two swapped a coordinate") {
  const Slot s = slot(CameraDecision::pixel);
  CHECK(!is_net(replicate_points(SamplerKind::independent, s, 0, 0, 2, 6), 6));
  std::vector<Point2f> points = replicate_points(SamplerKind::sobol, s, 0, 0, 2, 6);
  std::swap(points[3].y, points[40].y);
  CHECK(!is_net(points, 6));
}

// The numbers of 2^k samples from the given one on, in order.
std::vector<double> sorted_numbers(SamplerKind kind, Slot s, std::uint64_t first, int k, bool y) {
  std::vector<double> numbers;
  for (std::uint64_t j = first; j < first + (1ULL << k); ++j) {
    const Point2f p = Sampler::at(kind, 3, 77, j, 1).get_2d(s);
    numbers.push_back(static_cast<double>(y ? p.y : p.x));
  }
  std::ranges::sort(numbers);
  return numbers;
}

// Whether the numbers of the lattice are equally far apart.
bool is_even(Slot s, std::uint64_t first, int k, bool y) {
  const std::vector<double> numbers = sorted_numbers(SamplerKind::lattice, s, first, k, y);
  for (std::size_t i = 1; i < numbers.size(); ++i)
    if (numbers[i] - numbers[i - 1] != std::ldexp(1.0, -k)) return false;
  return true;
}

// Whether each stratum of 2^-k has one of the numbers.
bool is_in_strata(SamplerKind kind, Slot s, std::uint64_t first, int k, bool y) {
  const std::vector<double> numbers = sorted_numbers(kind, s, first, k, y);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (std::floor(std::ldexp(numbers[i], k)) != static_cast<double>(i)) return false;
  return true;
}

TEST("each dimension is even over any 2^k samples from a multiple of 2^k on, of the lattice and of Sobol'") {
  for (std::uint32_t index = 0; index < kDimensionSlots; ++index) {
    if (first_dimension(Slot{index}) == 0) continue;
    for (const int k : {1, 4, 10})
      for (const std::uint64_t block : {0ULL, 1ULL, 5ULL}) {
        for (const bool y : {false, true}) {  // the y of a single number is that of the next dimension
          CHECK(is_even({index}, block << k, k, y));
          CHECK(is_in_strata(SamplerKind::sobol, {index}, block << k, k, y));
        }
      }
  }
  const Slot pixel = slot(CameraDecision::pixel);
  CHECK(!is_even(pixel, 3, 4, false));  // not from a multiple on
  CHECK(!is_in_strata(SamplerKind::independent, pixel, 0, 4, false));
}

// The mean over 2^k points of the product of 1 + g w over some coordinates: how far from even they are together.
double unevenness(const std::vector<std::vector<double>>& coordinates) {
  double sum = 0;
  for (std::size_t i = 0; i < coordinates[0].size(); ++i) {
    double product = 1;
    for (const std::vector<double>& x : coordinates)
      product *= 1 + 0.05 * 2 * std::numbers::pi * std::numbers::pi * (x[i] * x[i] - x[i] + 1.0 / 6);
    sum += product;
  }
  return sum / static_cast<double>(coordinates[0].size()) - 1;
}

TEST("Sobol' points of the pixel and three vertices are together more even than padded ones") {
  const auto mean = [](std::uint32_t bounce, bool also_pixel) {
    double sum = 0;
    for (std::uint64_t pixel = 0; pixel < 100; ++pixel) {
      std::vector<std::vector<double>> coordinates;
      const auto add = [&](Slot s) {
        std::vector<double> x, y;
        for (std::uint64_t j = 0; j < 256; ++j) {
          const Point2f p = Sampler::at(SamplerKind::sobol, 5, pixel, j, 1).get_2d(s);
          x.push_back(static_cast<double>(p.x)), y.push_back(static_cast<double>(p.y));
        }
        coordinates.insert(coordinates.end(), {x, y});
      };
      add(also_pixel ? slot(CameraDecision::pixel) : slot(BounceDecision::bsdf_direction, bounce + 3));
      for (std::uint32_t b = bounce; b < bounce + 3; ++b) add(slot(BounceDecision::bsdf_direction, b));
      sum += unevenness(coordinates);
    }
    return sum / 100;
  };
  CHECK(mean(0, true) < 0.8 * mean(20, false));
}

TEST("decisions of a vertex that never meet in a product share the strata of Sobol', each scrambled by itself") {
  const auto strata = [](std::uint32_t a, std::uint32_t b) {  // of light points, and of directions
    std::set<std::pair<int, int>> found;
    for (std::uint64_t index = 0; index < 256; ++index) {
      const Sampler s = Sampler::at(SamplerKind::sobol, 5, 9, index, 1);
      found.emplace(static_cast<int>(16 * s.vertex(a).light_point.y),
                    static_cast<int>(16 * s.vertex(b).bsdf_direction.y));
    }
    return found.size();
  };
  CHECK(strata(0, 0) == 16 && strata(7, 7) == 16);
  CHECK(strata(0, 1) > 64);  // of two vertices
}

TEST("direction numbers are those that Joe and Kuo's program makes") {
  // Bits 0, 4, 9 and 19 of dimensions 3, 24 and 61, as fractions of 32 bits.
  const auto direction = [](std::size_t dimension, std::uint32_t bit) {
    return reverse_bits(sobol::kReversedDirections[dimension - 1][31 - bit]);
  };
  CHECK(direction(3, 0) == 0x80000000U && direction(3, 4) == 0xe8000000U && direction(3, 9) == 0x9cc00000U &&
        direction(3, 19) == 0xc5909000U);
  CHECK(direction(24, 0) == 0x80000000U && direction(24, 4) == 0x48000000U && direction(24, 9) == 0x32400000U &&
        direction(24, 19) == 0x4e9e3000U);
  CHECK(direction(61, 0) == 0x80000000U && direction(61, 4) == 0xf8000000U && direction(61, 9) == 0x1a400000U &&
        direction(61, 19) == 0x7eac3000U);
}

TEST("decisions of a vertex that never meet in a product share the lattice's components, shifted") {
  for (const std::uint32_t bounce : {0U, 7U}) {
    std::set<float> apart;
    for (std::uint64_t index = 0; index < 256; ++index) {
      const VertexNumbers v = Sampler::at(SamplerKind::lattice, 5, 9, index, 1).vertex(bounce);
      const float off = v.light_point.y - v.bsdf_direction.y;
      apart.insert(off < 0 ? off + 1 : off);
    }
    CHECK(apart.size() == 1);
  }
  std::set<float> others;  // of another vertex
  for (std::uint64_t index = 0; index < 256; ++index) {
    const Sampler s = Sampler::at(SamplerKind::lattice, 5, 9, index, 1);
    others.insert(s.vertex(0).light_point.y - s.vertex(1).light_point.y);
  }
  CHECK(others.size() > 16);
}

// 64 times the variance, over pixels, of the mean over 64 samples of what two slots do together at their coarsest: the
// sign of being in the lower half in one, times that in the other. Independent numbers give 1.
double coarse_variance(SamplerKind kind, Slot a, Slot b) {
  constexpr int kPixels = 4000;
  double squares = 0;
  for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
    int sum = 0;
    for (std::uint64_t index = 0; index < 64; ++index) {
      const Sampler s = Sampler::at(kind, 3, pixel, index, 1);
      sum += (s.get_2d(a).x < 0.5F) == (s.get_2d(b).x < 0.5F) ? 1 : -1;
    }
    squares += sum * sum;
  }
  return squares / (64.0 * kPixels);
}

TEST("slots without dimensions are padded as independent of each other; shuffled by nested scrambling they are not") {
  const Slot a = slot(BounceDecision::bsdf_direction, 9), b = slot(BounceDecision::bsdf_direction, 10);
  const double most = 1 + 5 * std::sqrt(2.0 / 4000);  // five standard deviations
  for (const SamplerKind kind : {SamplerKind::lattice, SamplerKind::sobol}) {
    CHECK(coarse_variance(kind, a, b) < most);
    CHECK(coarse_variance(kind, slot(BounceDecision::technique, 0), b) < most);
  }
  CHECK(coarse_variance(SamplerKind::stratified, a, b) > 1.8);
}

// How far from even the points of a vector are.
double vector_unevenness(const std::vector<std::uint32_t>& vector, int k) {
  std::vector<std::vector<double>> coordinates;
  for (const std::uint32_t z : vector) {
    std::vector<double>& x = coordinates.emplace_back();
    for (std::uint32_t i = 0; i < (1U << k); ++i) x.push_back(static_cast<double>(reverse_bits(i) * z) * 0x1p-32);
  }
  return unevenness(coordinates);
}

TEST("the vector is better for the first three vertices than random vectors are") {
  constexpr std::size_t kTogether = 11;  // the pixel and three vertices
  const std::vector<std::uint32_t> ours(lattice::kVector, lattice::kVector + kTogether);
  std::mt19937 random(1);
  for (const int k : {6, 10, 14})
    for (int trial = 0, better = 0; trial < 40; ++trial) {
      std::vector<std::uint32_t> other(kTogether);
      for (std::uint32_t& z : other) z = static_cast<std::uint32_t>(random()) | 1;
      better += vector_unevenness(other, k) < vector_unevenness(ours, k) ? 1 : 0;
      CHECK(better <= 2);
    }
  std::vector<std::uint32_t> twin = ours;
  twin[4] = twin[2];  // two that are alike
  CHECK(vector_unevenness(twin, 10) > 1.05 * vector_unevenness(ours, 10));
}

// Of 2^k samples of a replicate, those of all copies.
std::vector<Point2f> copied_points(SamplerKind kind, Slot s, int k, std::uint32_t log2_copies) {
  std::vector<Point2f> points;
  for (std::uint64_t j = 0; j < (1ULL << k); ++j)
    for (std::uint32_t copy = 0; copy < (1U << log2_copies); ++copy)
      points.push_back(Sampler::at(kind, 11, 7, 2 * j + 1, 2).copy(copy, log2_copies).get_2d(s));
  return points;
}

TEST("the points of all copies of 2^k samples are a net too, and share no number with the samples") {
  for (const Slot s : {slot(CameraDecision::pixel), kPadded})
    for (const std::uint32_t log2_copies : {1U, 2U, 4U}) {
      const std::vector<Point2f> copies = copied_points(SamplerKind::sobol, s, 5, log2_copies);
      CHECK(is_net(copies, 5 + static_cast<int>(log2_copies)));
      CHECK(!is_net(copied_points(SamplerKind::independent, s, 5, log2_copies), 5 + static_cast<int>(log2_copies)));
      std::set<float> numbers;
      for (const Point2f& p : copies) numbers.insert(p.x);
      for (const Point2f& p : replicate_points(SamplerKind::sobol, s, 7, 1, 2, 5)) numbers.insert(p.x);
      CHECK(numbers.size() == copies.size() + 32);
    }
}

TEST("single numbers are stratified in the same way") {
  for (const SamplerKind kind : {SamplerKind::stratified, SamplerKind::sobol})
    for (const Slot s : some_slots())
      for (std::uint32_t k = kind == SamplerKind::sobol && first_dimension(s) == 0 ? kLeastPadded : 0; k <= 10; ++k) {
        std::set<std::uint64_t> strata;
        for (std::uint64_t j = 0; j < (1ULL << k); ++j)
          strata.insert(k == 0 ? 0 : Sampler::at(kind, 2, 5, 2 * j, 2).bits(s) >> (64 - k));
        CHECK(strata.size() == 1ULL << k);
      }
}

// Whether of 4^k points of a replicate, from the given one on, one lies in each cell of 2^k by 2^k.
bool is_stratified(SamplerKind kind, Slot s, std::uint32_t replicate, std::uint32_t replicates, std::uint64_t first,
                   int k) {
  const auto count = std::uint64_t{1} << (2 * k);
  std::set<std::pair<int, int>> cells;
  for (std::uint64_t j = first; j < first + count; ++j) {
    const Point2f p = Sampler::at(kind, 13, 8, j * replicates + replicate, replicates).get_2d(s);
    cells.emplace(static_cast<int>(std::ldexp(p.x, k)), static_cast<int>(std::ldexp(p.y, k)));
  }
  return cells.size() == count;
}

TEST("of every 4^k stratified samples of a replicate and slot, one lies in each of 4^k strata") {
  for (const Slot s : some_slots())
    for (const std::uint32_t replicates : {1U, 2U, 3U})
      for (std::uint32_t r = 0; r < replicates; ++r)
        for (int k = 0; k <= 5; ++k)
          for (const std::uint64_t block : {0U, 1U, 2U, 7U})
            CHECK(is_stratified(SamplerKind::stratified, s, r, replicates, block << (2 * k), k));
}

TEST("the test of strata rejects independent samples, and stratified ones from the middle of 16") {
  int independent = 0, shifted = 0;
  for (const Slot s : some_slots()) {
    independent += is_stratified(SamplerKind::independent, s, 0, 2, 0, 2) ? 1 : 0;
    shifted += is_stratified(SamplerKind::stratified, s, 0, 2, 2, 2) ? 1 : 0;  // by chance, in half the slots at most
  }
  CHECK(independent == 0 && shifted < static_cast<int>(some_slots().size()));
}

// χ² of pairs of numbers over 16 × 16 cells; each pair comes from another pixel, so that pairs are independent.
template <class First, class Second>
double pair_deviate(First first, Second second) {
  constexpr int kSide = 16, kPairs = 1 << 17;
  std::vector<double> counts(kSide * kSide, 0);
  for (std::uint64_t pixel = 0; pixel < kPairs; ++pixel) {
    const auto i = static_cast<std::size_t>(first(pixel) * kSide), j = static_cast<std::size_t>(second(pixel) * kSide);
    ++counts[i * kSide + j];
  }
  return statistics::chi_squared_deviate(counts, std::vector<double>(counts.size(), double{kPairs} / (kSide * kSide)));
}

TEST("numbers of different slots, samples, replicates and neighbouring pixels are independent") {
  const auto number = [](SamplerKind kind, std::uint64_t index, Slot s, bool y = false) {
    return [=](std::uint64_t pixel) {
      const Point2f p = Sampler::at(kind, 21, pixel, index, 2).get_2d(s);
      return y ? p.y : p.x;
    };
  };
  const Slot light = slot(BounceDecision::light_point, 0), bsdf = slot(BounceDecision::bsdf_direction, 0);
  const Slot later = slot(BounceDecision::light_point, 1);
  for (const SamplerKind kind : kKinds) {
    const auto a = number(kind, 6, light);
    CHECK(std::abs(pair_deviate(a, number(kind, 6, bsdf))) < statistics::kReject);
    CHECK(std::abs(pair_deviate(a, number(kind, 6, later))) < statistics::kReject);
    CHECK(std::abs(pair_deviate(a, number(kind, 6, light, true))) < statistics::kReject);
    CHECK(std::abs(pair_deviate(a, number(kind, 7, light))) < statistics::kReject);
    const auto neighbour = [a](std::uint64_t pixel) { return a(pixel + 1); };
    CHECK(std::abs(pair_deviate(a, neighbour)) < statistics::kReject);
  }
  // Samples 4 and 6 are neighbours in one replicate: stratified, not independent. The test sees it.
  for (const SamplerKind kind : {SamplerKind::stratified, SamplerKind::sobol})
    CHECK(pair_deviate(number(kind, 6, light), number(kind, 4, light)) > statistics::kReject);
}

// Within a pixel, the first bits of two slots over 64 samples. Points come in pairs that differ in their first bit; the
// pairing is random from one pair to the next if the slots are shuffled independently, so that the number of pairs that
// agree is binomial. Slots shuffled alike would agree in all pairs or in none.
template <class Bits>
double shuffle_deviate(Bits second) {
  constexpr int kPairs = 32, kPixels = 1 << 15;
  std::vector<double> counts(kPairs + 1, 0), expected;
  const Slot first = slot(BounceDecision::light_point, 2);
  for (std::uint64_t pixel = 0; pixel < kPixels; ++pixel) {
    std::size_t agree = 0;
    for (std::uint64_t j = 0; j < 2 * kPairs; j += 2) {
      const Sampler s = Sampler::at(SamplerKind::stratified, 31, pixel, j, 1);
      agree += (s.bits(first) >> 63) == (second(s) >> 63) ? 1 : 0;
    }
    ++counts[agree];
  }
  double probability = kPixels * 0x1p-32;  // of `agree` agreements: C(32, agree) / 2^32
  for (int agree = 0; agree <= kPairs; ++agree) {
    expected.push_back(probability);
    probability *= static_cast<double>(kPairs - agree) / (agree + 1);
  }
  // The tails, too rare for χ², are one class each.
  for (const int from : {0, kPairs}) {
    const int step = from == 0 ? 1 : -1;
    for (int i = from; i != from + 7 * step; i += step) {
      counts[static_cast<std::size_t>(i + step)] += std::exchange(counts[static_cast<std::size_t>(i)], 0);
      expected[static_cast<std::size_t>(i + step)] += std::exchange(expected[static_cast<std::size_t>(i)], 0);
    }
  }
  const auto inner = [](const std::vector<double>& v) { return std::vector<double>(v.begin() + 7, v.end() - 7); };
  return statistics::chi_squared_deviate(inner(counts), inner(expected));
}

TEST("slots of one pixel are shuffled independently of each other") {
  for (const Slot s : {slot(BounceDecision::bsdf_direction, 2), slot(BounceDecision::light_point, 3)})
    CHECK(std::abs(shuffle_deviate([s](const Sampler& sampler) { return sampler.bits(s); })) < statistics::kReject);
}

TEST("the shuffling test rejects a slot that goes with another one in every fiftieth pixel") {
  const Slot s = slot(BounceDecision::bsdf_direction, 2), same = slot(BounceDecision::light_point, 2);
  CHECK(shuffle_deviate([&, calls = 0](const Sampler& sampler) mutable {
          return sampler.bits(calls++ / 32 % 50 == 0 ? same : s);
        }) > statistics::kReject);
}

}  // namespace

int main() { return check::run(); }
