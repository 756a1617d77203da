#include "film/error_parts.h"

#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <vector>

#include "film/statistics.h"
#include "math/threads.h"

namespace equaltime {

namespace {

constexpr std::size_t kRadius = 3, kChannels = 3;
constexpr double kMean = 1.0 / static_cast<double>(kChannels);
constexpr std::size_t kBandRows = 32;  // few enough for the cache, with the rows around that neighbourhoods need

using Doubles = std::vector<double>;

/// How many of a line's pixels lie within the radius of one.
double near_count(std::size_t at, std::size_t length) noexcept {
  const std::size_t first = at < kRadius ? 0 : at - kRadius;
  return static_cast<double>(std::min(at + kRadius + 1, length) - first);
}

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
    pixels = {image.mean + kChannels * skipped, image.variance + kChannels * skipped, image.samples + skipped,
              std::min(end + halo, image.height) - first, image.width};
  }

  [[nodiscard]] std::size_t size() const noexcept { return kChannels * pixels.height * pixels.width; }
  void box_sum(const double* values, Doubles& sums) const {
    equaltime::box_sum({values, size()}, pixels.height, pixels.width, kChannels, sums);
  }
  /// f(index of a value, one over the number of pixels of its neighbourhood), of rows of `pixels`.
  template <class F>
  void each(std::size_t from, std::size_t to, const F& f) const {
    for (std::size_t y = from, i = kChannels * from * pixels.width; y < to; ++y) {
      const double rows = near_count(first + y, image_height);
      for (std::size_t x = 0; x < pixels.width; ++x) {
        const double share = 1.0 / (rows * near_count(x, pixels.width));
        for (std::size_t c = 0; c < kChannels; ++c, ++i) f(i, share);
      }
    }
  }
  template <class F>
  void each_own(const F& f) const {
    each(begin - first, end - first, f);
  }
};

/// The memory of one thread, taken once.
struct Scratch {
  Doubles noise, local, shared, sums, errors;

  void fit(std::size_t size) {
    for (Doubles* values : {&noise, &local, &shared, &sums, &errors}) values->resize(size);
  }
};

/// work(band, number of the band, scratch) for all bands of an image.
template <class Work>
void over_bands(const PixelEstimates& image, std::size_t halo, const Work& work) {
  const std::size_t bands = (image.height + kBandRows - 1) / kBandRows;
  const auto cores = static_cast<std::size_t>(tbb::info::default_concurrency());
  std::atomic<std::size_t> next{0};
  on_threads(static_cast<unsigned>(std::max<std::size_t>(std::min(bands, cores), 1)), [&](unsigned) {
    Scratch scratch;
    for (std::size_t i = next++; i < bands; i = next++) {
      const Band band(image, i * kBandRows, halo);
      scratch.fit(band.size());
      work(band, i, scratch);
    }
  });
}

/// Whether all pixels have as many samples, and a known variance: then one sum serves for all.
bool even(const PixelEstimates& image) noexcept {
  const std::size_t pixels = image.height * image.width;
  for (std::size_t i = 0; i < pixels; ++i)
    if (image.samples[i] != image.samples[0] || !std::isfinite(image.variance[kChannels * i])) return false;
  return true;
}

/// `errors` of the band's own rows from its variances, of which `noise` is the sum over neighbourhoods. Uses `sums` and
/// `shared` where pixels are uneven.
void pool(const Band& band, bool is_even, Scratch& s) {
  if (is_even) {
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

/// The reference R of a pixel, by which its noise is measured. As Lee's filter does (Lee 1980), it weighs the pixel
/// against the local mean by how much of the local scatter is more than the noise: at an edge the local mean is wrong
/// by much, and the pixel by little once it has converged. Noise is skewed: a pixel that has met a rare bright path has
/// a large variance and is itself too bright, and would excuse itself. So R leans from the pixel towards the darker of
/// two replicates (which is its standard error below it), half way.
struct Reference {
  double value, shared, lean;  // `shared`: the share of the local mean

  Reference(double mean, double variance, double local, double noise, double scatter) noexcept
      : shared(scatter > 0.0 ? std::min(noise / scatter, 1.0) : 1.0), lean(std::sqrt(variance) * (1.0 - shared)) {
    value = std::max(local + (mean - local) * (1.0 - shared) - 0.5 * lean, 0.0);
  }
};

/// Contributions of the band's own rows; and `shared`, how much each local mean moves them, of all rows but the outer.
ErrorSums contribute(const Band& band, double floor, Scratch& s, double* contributions) {
  ErrorSums sums;
  const std::size_t own_begin = kChannels * (band.begin - band.first) * band.pixels.width;
  const std::size_t own_end = kChannels * (band.end - band.first) * band.pixels.width;
  band.each(0, band.pixels.height, [&](std::size_t i, double share) {
    const double variance = band.pixels.variance[i];
    const Reference reference(band.pixels.mean[i], variance, s.local[i], s.noise[i], s.sums[i]);
    const double inverse = 1.0 / (reference.value * reference.value + floor);
    const double part = variance * inverse, slope = part * inverse, moved = slope * reference.value;
    s.shared[i] = 2.0 * share * reference.shared * moved;
    if (i < own_begin || i >= own_end) return;
    contributions[(i - own_begin) / kChannels] += part * kMean;
    sums.slopes += slope;
    sums.leant += moved * reference.lean;
    // structure that rests on the local mean is below the noise
    sums.smooth += std::min(part * std::sqrt(part), part) * reference.shared;
  });
  return sums;
}

}  // namespace

void ErrorSums::add(const ErrorSums& other) noexcept {
  slopes += other.slopes;
  smooth += other.smooth;
  leant += other.leant;
  locals_squared += other.locals_squared;
  crossed += other.crossed;
  means_squared += other.means_squared;
}

ErrorSums error_parts(const PixelEstimates& image, double floor, std::span<double> contributions) {
  const bool is_even = even(image);
  std::vector<ErrorSums> found((image.height + kBandRows - 1) / kBandRows);
  std::fill(contributions.begin(), contributions.end(), 0.0);
  over_bands(image, 3 * kRadius, [&](const Band& band, std::size_t number, Scratch& s) {
    band.box_sum(band.pixels.variance, s.noise);
    pool(band, is_even, s);
    band.box_sum(band.pixels.mean, s.local);
    band.each(0, band.pixels.height, [&](std::size_t i, double share) {
      s.local[i] *= share;
      const double apart = band.pixels.mean[i] - s.local[i];
      s.shared[i] = apart * apart;
    });
    band.box_sum(s.shared.data(), s.sums);
    ErrorSums& sums = found[number];
    sums = contribute(band, floor, s, contributions.data() + band.begin * image.width);
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
  const bool is_even = even(image);
  over_bands(image, kRadius, [&](const Band& band, std::size_t, Scratch& s) {
    band.box_sum(band.pixels.variance, s.noise);
    pool(band, is_even, s);
    const std::size_t before = kChannels * band.first * image.width;
    band.each_own([&](std::size_t i, double) {
      const bool fits = s.errors[i] <= static_cast<double>(std::numeric_limits<float>::max());
      errors[before + i] = fits ? static_cast<float>(s.errors[i]) : std::numeric_limits<float>::infinity();
    });
  });
}

}  // namespace equaltime
