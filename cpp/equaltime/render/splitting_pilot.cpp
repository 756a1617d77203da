#include "equaltime/render/splitting_pilot.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/transport/sample_pixel.h"
#include "equaltime/transport/splitting_map.h"

namespace equaltime {

namespace {

constexpr std::uint64_t kSeed = 0xea450000ea45;  // of the pilot's numbers
constexpr std::uint64_t kFilmPixels = 64;        // of the film for one of the pilot, within these bounds
constexpr std::uint64_t kLeastPixels = 256, kMostPixels = 4096;
constexpr std::uint64_t kSide = 4;  // of a square of pilot pixels, in pixels; each is judged by the mean of the others
constexpr std::size_t kReplicates = 2;
constexpr std::uint64_t kSamples = 4;  // of a replicate of a pixel: enough to see what the sampler does
constexpr std::size_t kCopies = 1U << SplittingPilot::kLog2Copies;
constexpr double kPaths = double{kReplicates * kSamples};

using Rgb = std::array<double, 3>;

/// Counts rays and keeps apart what a path brings: light that the camera sees, light found before the path forks, and
/// what each copy finds afterwards.
class PilotObserver : public PathObserver {
 public:
  void on(const event::PathStarted& path) noexcept {
    weight_ = path.filter_weight, copy_ = 0, split_ = false, seen_ = {}, before_ = {}, after_ = {};
    at_begin_ = rays + shadow_rays;
  }
  void on(const event::RayTraced&) noexcept { ++rays; }
  void on(const event::ShadowRayTraced&) noexcept { ++shadow_rays; }
  void on(const event::ShadowRayHit&) noexcept { ++shadow_rays; }
  void on(const event::EmissionAdded& added) noexcept { added.depth == 1 ? void(seen_ += added.L) : add(added.L); }
  void on(const event::DirectLightAdded& added) noexcept { add(added.L); }
  void on(const event::PathSplit&) noexcept { split_ = true, at_split_ = rays + shadow_rays; }
  void on(const event::CopyResumed&) noexcept { ++copy_; }

  /// Rays of the last path before it is split, and after.
  [[nodiscard]] double rays_before() const noexcept {
    return static_cast<double>((split_ ? at_split_ : rays + shadow_rays) - at_begin_);
  }
  [[nodiscard]] double rays_after() const noexcept {
    return split_ ? static_cast<double>(rays + shadow_rays - at_split_) : 0.0;
  }
  /// What the last path brought by scattering.
  [[nodiscard]] Rgb scattered() const noexcept {
    Spectrum sum = before_;
    for (const Spectrum& copy : after_) sum += copy;
    return weighted(sum);
  }
  /// What the camera saw of emitters.
  [[nodiscard]] Rgb seen() const noexcept { return weighted(seen_); }
  /// What a copy brought after the split, as if all were like it.
  [[nodiscard]] Rgb alone(std::size_t copy) const noexcept { return weighted(after_[copy] * kCopies); }

  std::uint64_t rays = 0, shadow_rays = 0;

 private:
  void add(const Spectrum& L) noexcept { (split_ ? after_[copy_] : before_) += L; }
  [[nodiscard]] Rgb weighted(const Spectrum& L) const noexcept {
    return {static_cast<double>(L.r) * weight_, static_cast<double>(L.g) * weight_, static_cast<double>(L.b) * weight_};
  }

  float weight_ = 1;
  bool split_ = false;
  std::size_t copy_ = 0;
  Spectrum seen_, before_;
  std::array<Spectrum, kCopies> after_;
  std::uint64_t at_begin_ = 0, at_split_ = 0;
};

/// A pixel before the picture's mean is known: by RGB, not yet relative.
struct RawPixel {
  std::uint32_t x, y;
  Rgb mean{}, seen{}, one{}, all{}, within{};
  double rays_shared = 0, rays_copy = 0;
};

/// Sums over the samples of each replicate.
struct Sums {
  Rgb of[kReplicates]{};

  void add(std::size_t replicate, const Rgb& L) noexcept {
    for (int c = 0; c < 3; ++c) of[replicate][c] += L[c];
  }
  /// Mean of all samples, and its variance by the two replicates.
  [[nodiscard]] double mean(int c) const noexcept { return (of[0][c] + of[1][c]) / kPaths; }
  [[nodiscard]] Rgb variance() const noexcept {
    Rgb v{};
    for (int c = 0; c < 3; ++c) v[c] = square((of[0][c] - of[1][c]) / kPaths);
    return v;
  }
};

/// Adds the copies' variance of the last path, as that of the mean of the pixel's samples.
void add_within(const PilotObserver& pilot, Rgb& within) noexcept {
  constexpr double count = kCopies;
  for (int c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (std::size_t k = 0; k < kCopies; ++k) sum += pilot.alone(k)[c], squares += square(pilot.alone(k)[c]);
    within[c] += std::max(0.0, squares - sum * sum / count) / ((count - 1) * kPaths * kPaths);
  }
}

/// Renders one pixel with one copy and with all of them. None if a sample is not finite: it says nothing.
std::optional<RawPixel> render_pixel(const BlockTask& plain, const BlockTask& split, std::uint64_t x, std::uint64_t y,
                                     PilotObserver& pilot) {
  RawPixel pixel{static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)};
  Sums seen, one, all;
  for (std::uint64_t i = 0; i < kReplicates * kSamples; ++i) {
    const std::size_t replicate = i % kReplicates;
    if (!sample_film_pixel<kAllEffects>(plain, x, y, i, pilot).is_finite()) return {};
    one.add(replicate, pilot.scattered());
    if (!sample_film_pixel<kAllEffects>(split, x, y, i, pilot).is_finite()) return {};
    all.add(replicate, pilot.scattered()), seen.add(replicate, pilot.seen());
    add_within(pilot, pixel.within);
    pixel.rays_shared += pilot.rays_before() / kPaths;
    pixel.rays_copy += pilot.rays_after() / (kPaths * kCopies);
  }
  for (int c = 0; c < 3; ++c) pixel.mean[c] = seen.mean(c) + (one.mean(c) + all.mean(c)) / 2;
  pixel.seen = seen.variance(), pixel.one = one.variance(), pixel.all = all.variance();
  return pixel;
}

/// Relative to what is seen around the pixel, without itself: a pixel whose few samples miss its light must not count
/// for more, and one that meets a rare bright path not for less.
PilotPixel relative(const RawPixel& raw, const Rgb& around, double image_mean) noexcept {
  PilotPixel p{raw.x, raw.y, 0, 0, 0, 0, raw.rays_shared, raw.rays_copy};
  for (int c = 0; c < 3; ++c) {
    const double scale = 1 / (3 * (square(around[c]) + square(0.1 * image_mean)));
    p.seen += raw.seen[c] * scale, p.one += raw.one[c] * scale, p.all += raw.all[c] * scale;
    p.within += raw.within[c] * scale;
  }
  return p;
}

/// Mean of the others of a square; of itself if it is alone.
Rgb mean_of_others(const std::vector<RawPixel>& square_of_pixels, const RawPixel& pixel) noexcept {
  if (square_of_pixels.size() < 2) return pixel.mean;
  Rgb sum{};
  for (const RawPixel& other : square_of_pixels)
    for (int c = 0; c < 3; ++c) sum[c] += &other == &pixel ? 0.0 : other.mean[c];
  for (double& value : sum) value /= static_cast<double>(square_of_pixels.size() - 1);
  return sum;
}

}  // namespace

SplittingPilot render_splitting_pilot(const Scene& scene, const Settings& given, unsigned threads, Stop& stop) {
  scene.lights.prepare(given.light_selection, given.environment_sampling);
  const SplittingMap copies = SplittingMap::uniform(SplittingPilot::kLog2Copies);
  Settings plain = given, split = given;
  plain.roulette = split.roulette = Roulette::efficiency;
  plain.splitting_map = nullptr, split.splitting_map = &copies;
  const std::uint64_t width = scene.camera.film.width, height = scene.camera.film.height;
  const std::uint64_t wide = (width + kSide - 1) / kSide, high = (height + kSide - 1) / kSide;
  std::vector<std::vector<RawPixel>> squares(std::clamp(width * height / kFilmPixels, kLeastPixels, kMostPixels) /
                                             (kSide * kSide));
  SplittingPilot pilot;
  std::atomic<std::uint64_t> rays{0}, shadow_rays{0};
  run_blocks(squares.size(), threads, stop, [&] {
    return [&](std::size_t i) {
      PilotObserver observer;
      const std::uint64_t place = mix64(kSeed + i) % (wide * high), x0 = place % wide * kSide,
                          y0 = place / wide * kSide;
      const BlockTask one{scene, plain, kSeed + i, {}, 0, 0, kReplicates},
          all{scene, split, kSeed + i, {}, 0, 0, kReplicates};
      for (std::uint64_t y = y0; y < std::min(y0 + kSide, height); ++y)
        for (std::uint64_t x = x0; x < std::min(x0 + kSide, width); ++x)
          if (const auto pixel = render_pixel(one, all, x, y, observer)) squares[i].push_back(*pixel);
      rays += observer.rays, shadow_rays += observer.shadow_rays;
    };
  });
  pilot.rays = rays, pilot.shadow_rays = shadow_rays;
  double sum = 0, count = 0;
  for (const auto& pixels : squares)
    for (const RawPixel& p : pixels) sum += (p.mean[0] + p.mean[1] + p.mean[2]) / 3, ++count;
  if (!(sum > 0)) return pilot;
  for (const auto& pixels : squares) {
    pilot.squares.emplace_back();
    for (const RawPixel& p : pixels)
      pilot.squares.back().push_back(relative(p, mean_of_others(pixels, p), sum / count));
  }
  return pilot;
}

}  // namespace equaltime
