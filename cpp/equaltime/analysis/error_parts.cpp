#include "equaltime/analysis/error_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "equaltime/base/run_blocks.h"
#include "equaltime/film/statistics.h"
#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

constexpr std::size_t kRadius = 3, kChannels = 3;
constexpr double kMean = 1.0 / static_cast<double>(kChannels);
constexpr std::size_t kBandRows = 64;  // few enough for the cache, with the rows around that neighbourhoods need

using Doubles = std::vector<double>;

/// How many pixels of a line lie within the radius before one, and behind it.
struct Beside {
  std::size_t before, behind;

  Beside(std::size_t at, std::size_t length) noexcept
      : before(std::min(at, kRadius)), behind(std::min(length - 1 - at, kRadius)) {}

  [[nodiscard]] std::size_t all() const noexcept { return before + 1 + behind; }
  [[nodiscard]] std::size_t next() const noexcept {
    return std::min<std::size_t>(before, 1) + 1 + std::min<std::size_t>(behind, 1);
  }
};

/// The pixels of a neighbourhood that lie in the image.
struct Neighbourhood {
  Beside rows, columns;

  /// One over their number.
  [[nodiscard]] double share() const noexcept { return 1.0 / static_cast<double>(rows.all() * columns.all()); }
  /// How many there are in each half, and next to the pixel, without the pixel itself.
  [[nodiscard]] std::array<double, PartSums::kHalves> halves() const noexcept {
    const auto others = [](std::size_t across, std::size_t all) { return static_cast<double>((across + 1) * all - 1); };
    return {others(rows.before, columns.all()), others(rows.behind, columns.all()), others(columns.before, rows.all()),
            others(columns.behind, rows.all())};
  }
  [[nodiscard]] double next() const noexcept { return static_cast<double>(rows.next() * columns.next() - 1); }
};

/// Rows `begin` to `end` of the image, and the rows `halo` around them, of which `pixels` is made.
struct Band {
  PixelEstimates pixels;
  std::size_t begin, end, first, image_height;

  Band(const PixelEstimates& image, std::size_t begin_row, std::size_t halo)
      : begin(begin_row),
        end(std::min(begin_row + kBandRows, image.height)),
        first(begin_row < halo ? 0 : begin_row - halo),
        image_height(image.height) {
    const std::size_t skipped = first * image.width;
    pixels = {image.mean + kChannels * skipped,
              image.variance + kChannels * skipped,
              image.samples + skipped,
              std::min(end + halo, image.height) - first,
              image.width,
              image.least == nullptr ? nullptr : image.least + kChannels * skipped};
  }

  [[nodiscard]] std::size_t size() const noexcept { return kChannels * pixels.height * pixels.width; }
  void box_sum(const double* values, Doubles& sums) const {
    equaltime::box_sum({values, size()}, pixels.height, pixels.width, kChannels, sums);
  }
  void others_sum(const double* values, Doubles& sums) const {
    equaltime::others_sum({values, size()}, pixels.height, pixels.width, kChannels, sums);
  }
  [[nodiscard]] Neighbourhood around(std::size_t x, std::size_t y) const noexcept {
    return {Beside(first + y, image_height), Beside(x, pixels.width)};
  }
  /// f(index of a value, one over the number of pixels of its neighbourhood), of rows of `pixels`.
  template <class F>
  void each(std::size_t from, std::size_t to, const F& f) const {
    for (std::size_t y = from, i = kChannels * from * pixels.width; y < to; ++y)
      for (std::size_t x = 0; x < pixels.width; ++x) {
        const double share = around(x, y).share();
        for (std::size_t c = 0; c < kChannels; ++c, ++i) f(i, share);
      }
  }
  template <class F>
  void each_own(const F& f) const {
    each(begin - first, end - first, f);
  }
};

/// The memory of one thread, taken once.
struct Scratch {
  Doubles noise, local, brightest, shared, sums, errors, others_noise, others_local, others_scatter;

  void fit(std::size_t size) {
    for (Doubles* values :
         {&noise, &local, &brightest, &shared, &sums, &errors, &others_noise, &others_local, &others_scatter})
      values->resize(size);
  }
};

/// work(band, number of the band, scratch) for all bands of an image.
template <class Work>
void over_bands(const PixelEstimates& image, std::size_t halo, const Work& work) {
  const std::size_t bands = (image.height + kBandRows - 1) / kBandRows;
  const std::size_t threads = std::max<std::size_t>(std::min<std::size_t>(bands, thread_count(0)), 1);
  run_blocks(bands, static_cast<unsigned>(threads), [&] {
    return [&, scratch = Scratch()](std::size_t i) mutable {
      const Band band(image, i * kBandRows, halo);
      scratch.fit(band.size());
      work(band, i, scratch);
    };
  });
}

/// Whether all pixels have as many samples, and a known variance: then one sum serves for all.
bool are_uniform(const PixelEstimates& image) noexcept {
  const std::size_t pixels = image.height * image.width;
  for (std::size_t i = 0; i < pixels; ++i)
    if (image.samples[i] != image.samples[0] || !std::isfinite(image.variance[kChannels * i])) return false;
  return true;
}

/// `errors` of the band's own rows from its variances, of which `noise` is the sum over neighbourhoods. Uses `sums` and
/// `shared` where pixels are not uniform.
void pool(const Band& band, bool uniform, Scratch& s) {
  if (uniform) {
    band.each_own([&](std::size_t i, double share) { s.errors[i] = std::sqrt(s.noise[i] * share); });
    return;
  }
  const auto known = [&](std::size_t i) { return std::isfinite(band.pixels.variance[i - i % kChannels]); };
  const auto count = [&](std::size_t i) { return static_cast<double>(band.pixels.samples[i / kChannels]); };
  for (std::size_t i = 0; i < band.size(); ++i) s.shared[i] = known(i) ? band.pixels.variance[i] * count(i) : 0.0;
  band.box_sum(s.shared.data(), s.sums);
  for (std::size_t i = 0; i < band.size(); ++i) s.shared[i] = known(i) ? 1.0 : 0.0;
  band.box_sum(s.shared.data(), s.errors);
  band.each_own([&](std::size_t i, double) {
    s.errors[i] = known(i) ? std::sqrt(s.sums[i] / std::max(s.errors[i] * count(i), 1.0))
                           : std::numeric_limits<double>::infinity();
  });
}

/// Local means of a pixel: with the pixel, without it, and the brightest that is likely.
struct LocalMeans {
  double local, others, brightest;
};

/// Standard errors by which the brightest half of a neighbourhood is taken to be darker than it looks.
constexpr double kSurely = 2;
/// Stands for the square of a distance that is certain, as noise is 0; finite, so that differences stay numbers.
constexpr double kCertain = 1e300;

/// Numbers of pixels in parts of a neighbourhood without the pixel itself, and one over each; 0 of none.
struct PartCounts {
  std::array<double, PartSums::kHalves> halves, shares;
  double next_share;

  explicit PartCounts(const Neighbourhood& around) noexcept : halves(around.halves()), next_share(over(around.next())) {
    for (std::size_t k = 0; k < halves.size(); ++k) shares[k] = over(halves[k]);
  }

 private:
  static double over(double count) noexcept { return count > 0 ? 1.0 / count : 0.0; }
};

/// Sums of one channel over the parts.
struct Parts {
  const std::array<double, PartSums::kHalves>&means, &variances;
  double next_mean, next_variance;
};

/// The squared distance of the mean of a half from the mean of the pixels next to the pixel, over its variance.
double distance(const Parts& parts, const PartCounts& counts, std::size_t half) noexcept {
  const double n = counts.shares[half], m = counts.next_share;
  const double apart = parts.means[half] * n - parts.next_mean * m, square = apart * apart;
  const double variance = parts.variances[half] * (n * n) + parts.next_variance * (m * m);
  return variance > 0 ? std::min(square / variance, kCertain) : (square > 0 ? kCertain : 0.0);
}

/// Local means that do not reach across edges. At an edge, one half of the neighbourhood is like the pixels next to the
/// pixel, and the opposite half is not. Each half counts by the likelihood that both have the same mean (edge-aligned
/// halves: Lee 1981).
LocalMeans local_means(const Parts& parts, const PartCounts& counts, double mean, double variance) noexcept {
  std::array<double, PartSums::kHalves> distances{};
  double least = kCertain;
  std::size_t brightest = 0;
  for (std::size_t k = 0; k < distances.size(); ++k) {
    if (!(counts.halves[k] > 0)) continue;
    least = std::min(least, distances[k] = distance(parts, counts, k));
    if (parts.means[k] * counts.shares[k] > parts.means[brightest] * counts.shares[brightest]) brightest = k;
  }
  double sum = 0, count = 0, weights = 0;
  for (std::size_t k = 0; k < distances.size(); ++k) {
    const double more = distances[k] - least, n = counts.halves[k];
    if (!(n > 0)) continue;
    const double weight = more > 0 ? elementary::exp(-0.5 * more) : 1.0;
    weights += weight;
    sum += weight * parts.means[k];
    count += weight * n;
  }
  if (!(count > 0)) return {mean, 0, mean};
  const double local = (sum + weights * mean) / (count + weights);
  const double surely = parts.means[brightest] + mean - kSurely * std::sqrt(parts.variances[brightest] + variance);
  return {local, sum / count, std::max(local, surely / (counts.halves[brightest] + 1))};
}

/// The local means of all rows of the band.
void find_local_means(const Band& band, Scratch& s) {
  const std::size_t width = band.pixels.width;
  PartSums means({band.pixels.mean, band.size()}, band.pixels.height, width, kChannels);
  PartSums variances({band.pixels.variance, band.size()}, band.pixels.height, width, kChannels);
  for (std::size_t y = 0, at = 0; y < band.pixels.height; ++y) {
    means.row(y), variances.row(y);
    for (std::size_t x = 0, i = 0; x < width; ++x) {
      const PartCounts counts(band.around(x, y));
      for (std::size_t c = 0; c < kChannels; ++c, ++i, ++at) {
        const Parts parts{means.halves(i), variances.halves(i), means.next(i), variances.next(i)};
        const LocalMeans found = local_means(parts, counts, band.pixels.mean[at], band.pixels.variance[at]);
        s.local[at] = found.local, s.others_local[at] = found.others, s.brightest[at] = found.brightest;
      }
    }
  }
}

/// A local mean, and sums over the whole neighbourhood: of the variances of its pixels, and of their squared distances
/// from local means of their own.
struct Around {
  double local, noise, scatter;

  /// The share of the local mean in a reference. As Lee's filter does (Lee 1980), it weighs the pixel against the local
  /// mean by how much of the local scatter is more than the noise: at an edge the local mean is wrong by much, and the
  /// pixel by little once it has converged.
  [[nodiscard]] double share() const noexcept { return scatter > 0.0 ? std::min(noise / scatter, 1.0) : 1.0; }
};

/// A reference R of a pixel, by which its noise is measured, and how much of the local mean is in it.
struct Reference {
  double value, shared;

  [[nodiscard]] double denominator(double floor) const noexcept { return value * value + floor; }
};

/// Noise is skewed: a pixel that has met a rare bright path has a large standard error and is itself too bright, so
/// that it excuses itself. The darker of its two replicates is its standard error below it. References lean towards
/// that by as much as the pixel is noise.
struct OwnPixel {
  double mean, deviation, least;

  /// The standard error over a brightness, at most 1.
  [[nodiscard]] double relative(double to) const noexcept {
    return deviation < to ? deviation / to : (deviation > 0 ? 1.0 : 0.0);
  }
  [[nodiscard]] double noise() const noexcept { return relative(mean); }
  /// The standard error over the darker replicate, at most 1: a bright path that one replicate has met makes it 1.
  [[nodiscard]] double noise_at_worst() const noexcept { return relative(mean - deviation); }
  [[nodiscard]] double leaning(double part) const noexcept { return std::max(mean - part * deviation, 0.0); }
};

/// The local mean and a leaning pixel, weighed against each other.
Reference reference(const OwnPixel& own, double leaning, const Around& around) noexcept {
  const double shared = around.share();
  return {std::max(around.local + (leaning - around.local) * (1.0 - shared), own.least), shared};
}

/// The weight of the denominator without the pixel in the geometric mean of both: its least value, and what is added
/// where the pixel is all noise. With these the median of stated over realised errors is 0.97 to 1.06 at 12 and 48
/// samples a pixel of the scenes flat, cornell, slit, door and glass (tests/bench/stated_errors.py).
constexpr double kLeastCaution = 0.2, kMoreCaution = 0.5;

/// Contributions of the band's own rows; and `shared`, how much each local mean moves them, of all rows but the outer.
ErrorSums contribute(const Band& band, double floor, Scratch& s, const ErrorContributions& contributions) {
  ErrorSums sums;
  const PixelEstimates& pixels = band.pixels;
  const std::size_t own_begin = kChannels * (band.begin - band.first) * pixels.width;
  const std::size_t own_end = kChannels * (band.end - band.first) * pixels.width;
  const std::size_t before = band.first * pixels.width;
  band.each(0, pixels.height, [&](std::size_t i, double share) {
    const double variance = pixels.variance[i];
    const OwnPixel own{pixels.mean[i], std::sqrt(variance), pixels.least == nullptr ? 0.0 : pixels.least[i]};
    const Around around{s.local[i], s.noise[i], s.sums[i]}, brighter{s.brightest[i], s.noise[i], s.sums[i]};
    const Around outside{s.others_local[i], s.others_noise[i], s.others_scatter[i]};
    const Reference with = reference(own, own.leaning(0.5 * own.noise()), around);
    const Reference lenient = reference(own, own.leaning(0.5 * own.noise()), brighter);
    const Reference without = reference(own, own.leaning(own.noise()), outside);
    const Reference cautious = reference(own, own.leaning(own.noise_at_worst()), outside);
    const double denominator_with = with.denominator(floor), denominator_without = without.denominator(floor);
    const double caution = kLeastCaution + kMoreCaution * std::max(without.shared, own.noise());
    // in this form it is scaled exactly where the light is, by a power of two
    const double part =
        variance / (denominator_with * elementary::pow(denominator_without / denominator_with, caution));
    const double by_with = (1.0 - caution) / denominator_with, by_without = caution / denominator_without;
    s.shared[i] =
        2.0 * share * part * (by_with * with.shared * with.value + by_without * without.shared * without.value);
    if (i < own_begin || i >= own_end) return;
    const std::size_t pixel = before + i / kChannels;
    contributions.value[pixel] += part * kMean;
    contributions.lenient[pixel] += variance / lenient.denominator(floor) * kMean;
    contributions.cautious[pixel] += variance / cautious.denominator(floor) * kMean;
    sums.slopes += part * (by_with + by_without);
  });
  return sums;
}

}  // namespace

void ErrorSums::add(const ErrorSums& other) noexcept {
  slopes += other.slopes;
  locals_squared += other.locals_squared;
  crossed += other.crossed;
  means_squared += other.means_squared;
}

ErrorSums error_parts(const PixelEstimates& image, double floor, const ErrorContributions& contributions) {
  const bool uniform = are_uniform(image);
  std::vector<ErrorSums> found((image.height + kBandRows - 1) / kBandRows);
  for (const std::span<double> part : {contributions.value, contributions.lenient, contributions.cautious})
    std::fill(part.begin(), part.end(), 0.0);
  over_bands(image, 3 * kRadius, [&](const Band& band, std::size_t number, Scratch& s) {
    band.box_sum(band.pixels.variance, s.noise);
    pool(band, uniform, s);
    find_local_means(band, s);
    for (std::size_t i = 0; i < band.size(); ++i) {
      const double apart = band.pixels.mean[i] - s.local[i];
      s.shared[i] = apart * apart;
    }
    band.box_sum(s.shared.data(), s.sums);
    band.others_sum(s.shared.data(), s.others_scatter);
    band.others_sum(band.pixels.variance, s.others_noise);
    ErrorSums& sums = found[number];
    sums = contribute(band, floor, s, contributions);
    band.box_sum(s.shared.data(), s.sums);
    for (std::size_t p = (band.begin - band.first) * image.width; p < (band.end - band.first) * image.width; ++p) {
      double by_local = 0, by_mean = 0;
      for (std::size_t i = kChannels * p; i < kChannels * (p + 1); ++i) {
        by_local += kMean * s.sums[i] * s.errors[i];
        by_mean += kMean * s.errors[i];
      }
      sums.locals_squared += by_local * by_local;
      sums.crossed += by_local * by_mean;
      sums.means_squared += by_mean * by_mean;
    }
  });
  ErrorSums total;
  for (const ErrorSums& sums : found) total.add(sums);
  return total;
}

void standard_errors(const PixelEstimates& image, std::span<float> errors) {
  const bool uniform = are_uniform(image);
  over_bands(image, kRadius, [&](const Band& band, std::size_t, Scratch& s) {
    band.box_sum(band.pixels.variance, s.noise);
    pool(band, uniform, s);
    const std::size_t before = kChannels * band.first * image.width;
    band.each_own([&](std::size_t i, double) {
      const bool fits = s.errors[i] <= static_cast<double>(std::numeric_limits<float>::max());
      errors[before + i] = fits ? static_cast<float>(s.errors[i]) : std::numeric_limits<float>::infinity();
    });
  });
}

}  // namespace equaltime
