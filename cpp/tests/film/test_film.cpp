// Pixel moments against sums in long double, and the parts of an error whose noise is known.
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "equaltime/analysis/error_parts.h"
#include "equaltime/film/film.h"
#include "equaltime/film/statistics.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

struct Exact {
  long double mean, m2;
};

Exact exact_moments(const std::vector<float>& values) {
  long double sum = 0;
  for (const float v : values) sum += static_cast<long double>(v);
  const long double mean = sum / static_cast<long double>(values.size());
  long double m2 = 0;
  for (const float v : values) m2 += (static_cast<long double>(v) - mean) * (static_cast<long double>(v) - mean);
  return {mean, m2};
}

PixelMoments moments(const std::vector<float>& values, double scale = 1) {
  PixelMoments m;
  for (const float v : values) m.add({v, 2 * v, -v}, scale);
  return m;
}

bool close(double value, long double exact, double relative) {
  return std::abs(static_cast<long double>(value) - exact) <= static_cast<long double>(relative) * std::abs(exact);
}

double deviation(const PixelMoments& m, int c) { return from_upper_half(m.deviation[c]); }

// Samples far from 0 with little spread: the sum of squares minus the squared sum would keep no digit of the variance.
std::vector<float> offset_samples(int count) {
  std::mt19937 random(1);
  std::normal_distribution<float> gauss(100000, 0.1F);
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(gauss(random));
  return values;
}

TEST("mean and squared deviations are right far from zero, where a sum of squares fails") {
  const std::vector<float> values = offset_samples(100000);
  const Exact exact = exact_moments(values);
  const PixelMoments m = moments(values);
  CHECK(m.count == values.size());
  CHECK(close(m.mean[0], exact.mean, 1e-14) && close(m.mean[1], 2 * exact.mean, 1e-14));
  CHECK(close(m.squares(0), exact.m2, 1e-3) && deviation(m, 1) == 2 * deviation(m, 0));
  CHECK(m.deviation[2] == m.deviation[0]);
  float square_sum = 0, sum = 0;  // the twin
  for (const float v : values) square_sum += v * v, sum += v;
  CHECK(!close(static_cast<double>(square_sum - sum * sum / static_cast<float>(values.size())), exact.m2, 0.1));
}

TEST("a hundred million samples of one value have that value for a mean, and no spread (E1)") {
  PixelMoments m;
  float sum = 0;
  for (int i = 0; i < 100'000'000; ++i) {
    m.add(Spectrum(0.1F), 1);
    sum += 0.1F;
  }
  CHECK(m.count == 100'000'000);
  for (int c = 0; c < 3; ++c) CHECK(m.mean[c] == static_cast<double>(0.1F) && m.deviation[c] == 0);
  CHECK(sum < 0.3F * 1e7F);  // the twin: where a sum in float32 stops growing
}

TEST("the mean of a pixel is that of its samples in all replicates, by either sharing") {
  for (const Sharing sharing : {Sharing::alternate, Sharing::halves}) {
    Film film(2, 3, 2, sharing);
    for (std::uint64_t i = 0; i < 7; ++i) {
      const auto value = static_cast<float>(i * i);
      film.add(1, 2, i, {value, 2 * value, 4}, 0.5);
    }
    const auto [r, g, b] = film.mean(1, 2);
    CHECK(close(r, 6.5L, 1e-15) && close(g, 13, 1e-15) && close(b, 2, 1e-15));
    CHECK((film.mean(0, 2) == std::array<double, 3>{}));
    CHECK_THROWS(std::out_of_range, "pixel (2, 0) is outside of a film of 2 x 3 pixels", film.mean(2, 0));
    CHECK_THROWS(std::out_of_range, "pixel (0, 3)", film.mean(0, 3));
  }
}

TEST("moments of parts merge to those of the whole, in any grouping") {
  const std::vector<float> values = offset_samples(3000);
  const auto part = [&](int from, int to) { return moments({values.begin() + from, values.begin() + to}); };
  const Exact exact = exact_moments(values);
  const PixelMoments a = part(0, 1), b = part(1, 700), c = part(700, 3000);
  for (const PixelMoments& m :
       {PixelMoments::merge(PixelMoments::merge(a, b), c), PixelMoments::merge(a, PixelMoments::merge(c, b))}) {
    CHECK(m.count == values.size());
    CHECK(close(m.mean[0], exact.mean, 1e-14) && close(m.squares(0), exact.m2, 1e-4));
  }
}

TEST("the spread of fifty million samples is right, where a sum of squares in float32 stops growing") {
  PixelMoments m;
  float squares = 0;  // the twin
  for (int i = 0; i < 50'000'000; ++i) {
    const float value = i % 2 == 0 ? 1.0F : 3.0F;
    m.add(Spectrum(value), 1);
    squares += (value - 2) * (value - 2);
  }
  CHECK(close(deviation(m, 0), 1, 1e-3));
  CHECK(squares < 0.4F * 5e7F);
}

TEST("the spread of samples of any size is known") {
  for (const double scale : {0x1p-400, 0x1p400}) {
    const PixelMoments m = moments({1, 2, 4, 3}, scale);
    CHECK(close(deviation(m, 0), scale * std::sqrt(1.25L), 1e-5));
  }
}

TEST("merging with nothing changes no bit") {
  const PixelMoments m = moments(offset_samples(10)), none;
  for (const PixelMoments& same : {PixelMoments::merge(m, none), PixelMoments::merge(none, m)})
    CHECK(same.count == m.count && same.mean[0] == m.mean[0] && same.deviation[2] == m.deviation[2]);
}

TEST("a scale that is a power of two goes through exactly") {
  const std::vector<float> values = offset_samples(1000);
  const PixelMoments one = moments(values), scaled = moments(values, 0x1p40);
  for (int c = 0; c < 3; ++c)
    CHECK(scaled.mean[c] == one.mean[c] * 0x1p40 && deviation(scaled, c) == deviation(one, c) * 0x1p40);
}

TEST("a film keeps its replicates and pixels apart, row by row") {
  Film film(3, 2, 2);
  film.at(1, 2, 1).add(Spectrum(5), 1);
  CHECK(film.moments().size() == 12);
  CHECK(film.moments()[11].mean[0] == 5);
  for (std::size_t i = 0; i < 11; ++i) CHECK(film.moments()[i].count == 0);
}

TEST("halves hold the largest power of two of samples that is less than all of them, and those after it") {
  Film film(2, 1, 2, Sharing::halves);
  for (std::uint64_t n = 1; n <= 70; ++n) {
    film.add(1, 0, n - 1, Spectrum(static_cast<float>(n)), 1);
    std::uint64_t first = 1;
    while (2 * first < n) first *= 2;
    const PixelMoments &a = film.at(0, 1, 0), &b = film.at(1, 1, 0);
    CHECK(a.count == first && b.count == n - first);
    CHECK(a.count == film.count_of(0, n) && b.count == film.count_of(1, n));
    const double sum = static_cast<double>(a.count) * a.mean[0] + static_cast<double>(b.count) * b.mean[0];
    CHECK(close(sum, static_cast<double>(n * (n + 1)) / 2, 1e-14));
    CHECK(close(a.mean[0], static_cast<double>(first + 1) / 2, 1e-14));
  }
  CHECK(film.at(0, 0, 0).count == 0 && film.count_of(0, 0) == 0 && film.count_of(1, 0) == 0);
}

TEST("a flat image whose pixels have one variance has one contribution everywhere, whatever band it is in") {
  constexpr std::size_t kHeight = 150, kWidth = 11;
  const std::vector<double> mean(3 * kHeight * kWidth, 2.0), variance(mean.size(), 0.5);
  std::vector<std::int64_t> samples(kHeight * kWidth, 8);
  const PixelEstimates pixels{mean.data(), variance.data(), samples.data(), kHeight, kWidth};
  std::vector<double> value(samples.size()), lenient(value), cautious(value);
  const ErrorContributions contributions{value, lenient, cautious};
  std::vector<float> errors(mean.size());
  const auto all_are_right = [&](double contribution) {
    const ErrorSums sums = error_parts(pixels, 1.0, contributions);
    standard_errors(pixels, errors);
    bool right = close(sums.slopes, contribution / 5 * static_cast<double>(mean.size()), 1e-12);
    for (const auto& by_reference : {value, lenient, cautious})
      for (const double c : by_reference) right = right && close(c, contribution, 1e-14);
    for (const float e : errors) right = right && close(static_cast<double>(e), std::sqrt(0.5L), 1e-6);
    return right;
  };
  CHECK(all_are_right(0.5 / (2.0 * 2.0 + 1.0)));
  CHECK(!all_are_right(0.5 / (2.0 * 2.0 + 1.001)));
  samples[5] = 9;  // no longer even: sums are weighed by counts
  (void)error_parts(pixels, 1.0, contributions);
  CHECK(close(value[0], 0.1, 1e-14));
  standard_errors(pixels, errors);
  CHECK(errors[3 * 4] > errors[3 * 1] && errors[3 * 5] < errors[3 * 1]);
}

TEST("a sum of others leaves a pixel out by not a bit, and so does a cautious reference") {
  constexpr std::size_t kSide = 9, kMiddle = 3 * (4 * kSide + 4);
  std::vector<double> image(3 * kSide * kSide, 1.0), sums(image.size()), whole(image.size());
  for (const double bright : {1.0, 0x1p60}) {
    image[kMiddle] = bright;
    others_sum(image, kSide, kSide, 3, sums);
    box_sum(image, kSide, kSide, 3, whole);
    CHECK(sums[kMiddle] == 48 && sums[0] == 15);
    CHECK(sums[kMiddle + 3] == 47 + bright);
  }
  CHECK(whole[kMiddle] != 49);
}

TEST("no reference is below the light that a pixel surely has") {
  constexpr std::size_t kSide = 8;
  const std::vector<double> mean(3 * kSide * kSide, 1.0), variance(mean.size(), 0.5), least(mean.size(), 3.0);
  const std::vector<std::int64_t> samples(kSide * kSide, 8);
  std::vector<double> value(samples.size()), lenient(value), cautious(value);
  const PixelEstimates pixels{mean.data(), variance.data(), samples.data(), kSide, kSide, least.data()};
  (void)error_parts(pixels, 1.0, {value, lenient, cautious});
  CHECK(close(value[0], 0.05, 1e-14) && close(lenient[9], 0.05, 1e-14) && close(cautious[63], 0.05, 1e-14));
}

}  // namespace

int main() { return check::run(); }
