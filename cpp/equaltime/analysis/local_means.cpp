#include "equaltime/analysis/local_means.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

struct PixelMeans {
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

PixelMeans local_means(const Parts& parts, const PartCounts& counts, double mean, double variance) noexcept {
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

}  // namespace

void LocalMeans::find(const Band& band) {
  const std::size_t width = band.pixels.width;
  PartSums sums({band.pixels.mean, band.size()}, band.pixels.height, width, kChannels);
  PartSums variances({band.pixels.variance, band.size()}, band.pixels.height, width, kChannels);
  for (std::size_t y = 0, at = 0; y < band.pixels.height; ++y) {
    sums.row(y), variances.row(y);
    for (std::size_t x = 0, i = 0; x < width; ++x) {
      const PartCounts counts(band.around(x, y));
      for (std::size_t c = 0; c < kChannels; ++c, ++i, ++at) {
        const Parts parts{sums.halves(i), variances.halves(i), sums.next(i), variances.next(i)};
        const PixelMeans found = local_means(parts, counts, band.pixels.mean[at], band.pixels.variance[at]);
        means[at] = found.local, others[at] = found.others, brightest[at] = found.brightest;
      }
    }
  }
}

}  // namespace equaltime
