#include "transport/efficiency.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "math/threads.h"
#include "transport/sample_pixel.h"

namespace equaltime {

namespace {

constexpr std::uint64_t kSeed = 0xea450000ea45;  // of the pilot's numbers
// Pilot paths that leave the camera: one for so many pixels of the film, within bounds.
constexpr std::uint64_t kPixelsAPath = 4, kLeastPaths = 2048, kMostPaths = 16384;
constexpr std::uint32_t kLog2Copies = 2;  // of each of them
constexpr std::size_t kCopies = 1U << kLog2Copies;
constexpr std::size_t kReplicates = 2;
constexpr std::uint64_t kSamples = 4;  // of a replicate of a pilot pixel: enough to see what the sampler does
constexpr double kPixelsABlock = 2;    // of the pilot, on average

/// What pilot paths do, before they fork and after.
class PilotProbe {
 public:
  static constexpr bool listens = true;
  static constexpr bool allocates = false;

  template <auto E>
  [[nodiscard]] MeetingOf<E> intersect(const Scene& scene, const Ray& ray) noexcept {
    ++rays_;
    return scene.intersect<E>(ray, time);
  }
  template <auto E>
  [[nodiscard]] bool occluded(const Scene& scene, const Ray& ray) noexcept {
    ++rays_;
    return scene.occluded<E>(ray, time);
  }
  template <auto E>
  [[nodiscard]] MeetingOf<E> blocker(const Scene& scene, const Ray& ray) noexcept {
    return intersect<E>(scene, ray);
  }

  void begin(float) noexcept { copy_ = 0, forked_ = false, before_ = {}, after_ = {}; }
  static void scatters(const Bsdf&) noexcept {}
  static void aims(const LightSample&) noexcept {}
  Spectrum met(const Spectrum& L, std::uint32_t, int) noexcept { return add(L); }
  Spectrum lit(const Spectrum& L, int) noexcept { return add(L); }
  template <class Event>
  void note(const Event&) noexcept {}
  void note(const event::Forks&) noexcept { forked_ = true, rays_at_fork_ = rays_; }
  void note(const event::Resumes&) noexcept { ++copy_; }
  static bool gives_up() noexcept { return false; }

  /// Of all paths so far.
  [[nodiscard]] std::uint64_t rays() const noexcept { return rays_; }
  /// Since the path forked, by all copies.
  [[nodiscard]] std::uint64_t rays_after() const noexcept { return forked_ ? rays_ - rays_at_fork_ : 0; }
  /// What the path would have brought with this copy alone.
  [[nodiscard]] Spectrum alone(std::size_t copy) const noexcept { return before_ + after_[copy] * kCopies; }

  float time = 0;  // as RayCounter's

 private:
  Spectrum add(const Spectrum& L) noexcept {
    (forked_ ? after_[copy_] : before_) += L;
    return L;
  }

  bool forked_ = false;
  std::size_t copy_ = 0;
  Spectrum before_;
  std::array<Spectrum, kCopies> after_;
  std::uint64_t rays_ = 0, rays_at_fork_ = 0;
};

/// What was seen in one pixel.
struct PilotPixel {
  double paths = 0;
  double mean[3] = {};
  double rays_shared = 0, rays_copy = 0;  // of all paths: before they fork, and of one copy of each
  double one[3] = {}, all[3] = {};        // variance of a path with one copy and with all, as the sampler makes it
  double within[3] = {};                  // variance among the copies of one path
};

struct Rgb {
  double value[3];
};

Rgb rgb(const Spectrum& s) noexcept {
  return {{static_cast<double>(s.r), static_cast<double>(s.g), static_cast<double>(s.b)}};
}

/// Renders one pixel of the pilot. Not a number: as if it had not been.
PilotPixel render_pixel(const BlockTask& task, std::uint64_t x, std::uint64_t y) {
  PilotProbe probe;
  PilotPixel p;
  Rgb sums[kReplicates][kCopies] = {};
  for (std::uint64_t i = 0; i < kReplicates * kSamples; ++i) {
    const std::uint64_t before = probe.rays();
    if (!sample_film_pixel<kAllEffects>(task, x, y, i, kReplicates, probe).is_finite()) return {};
    p.rays_copy += static_cast<double>(probe.rays_after()) / kCopies;
    p.rays_shared += static_cast<double>(probe.rays() - before - probe.rays_after());
    Rgb copies[kCopies];
    for (std::size_t k = 0; k < kCopies; ++k) copies[k] = rgb(probe.alone(k));
    for (int c = 0; c < 3; ++c) {
      double mean = 0;
      for (std::size_t k = 0; k < kCopies; ++k) mean += copies[k].value[c] / kCopies;
      for (std::size_t k = 0; k < kCopies; ++k) {
        sums[i % kReplicates][k].value[c] += copies[k].value[c];
        p.within[c] += square(copies[k].value[c] - mean) / ((kCopies - 1) * kReplicates * kSamples);
      }
      p.mean[c] += mean / (kReplicates * kSamples);
    }
  }
  for (int c = 0; c < 3; ++c) {
    double difference = 0;
    for (std::size_t k = 0; k < kCopies; ++k) {
      const double d = sums[0][k].value[c] - sums[1][k].value[c];
      p.one[c] += d * d / (kCopies * 2 * kSamples), difference += d / kCopies;
    }
    p.all[c] = square(difference) / (2 * kSamples);
  }
  p.paths = kReplicates * kSamples;
  return p;
}

/// What is seen of a part of the film: variances by the design's error, relative to the squares of a pixel and of a
/// tenth of the image's mean.
struct Seen {
  double paths = 0, rays_shared = 0, rays_copy = 0, one = 0, all = 0, within = 0;

  Seen& operator+=(const Seen& s) noexcept {
    paths += s.paths, rays_shared += s.rays_shared, rays_copy += s.rays_copy;
    one += s.one, all += s.all, within += s.within;
    return *this;
  }
  [[nodiscard]] Seen of_a_path() const noexcept {
    const double n = 1 / paths;
    return {1, rays_shared * n, rays_copy * n, one * n, all * n, within * n};
  }
};

Seen seen(const PilotPixel& p, double image_mean) noexcept {
  Seen s{p.paths, p.rays_shared, p.rays_copy};
  for (int c = 0; c < 3; ++c) {
    const double relative = p.paths / (3 * (square(p.mean[c]) + square(0.1 * image_mean)));
    s.one += p.one[c] * relative, s.all += p.all[c] * relative, s.within += p.within[c] * relative;
  }
  return s;
}

/// Blocks of the film with about so many pilot pixels each.
class Blocks {
 public:
  Blocks(const FilmDescription& film, std::size_t pilot_pixels)
      : side_(static_cast<std::uint64_t>(
            std::ceil(std::sqrt(kPixelsABlock * film.width * film.height / static_cast<double>(pilot_pixels))))),
        wide_((film.width + side_ - 1) / side_),
        high_((film.height + side_ - 1) / side_),
        seen_(wide_ * high_) {}

  void add(std::uint64_t x, std::uint64_t y, const Seen& s) noexcept { seen_[y / side_ * wide_ + x / side_] += s; }

  /// Of a path in each block, as seen there and in its neighbours and, as if it were a path more, in the image.
  [[nodiscard]] std::vector<Seen> smoothed(const Seen& image) const {
    std::vector<Seen> smooth(seen_.size(), image.of_a_path());
    for (std::uint64_t y = 0; y < high_; ++y)
      for (std::uint64_t x = 0; x < wide_; ++x) {
        Seen& sum = smooth[y * wide_ + x];
        for (std::uint64_t v = y - (y > 0); v < std::min(y + 2, high_); ++v)
          for (std::uint64_t u = x - (x > 0); u < std::min(x + 2, wide_); ++u) sum += seen_[v * wide_ + u];
        sum = sum.of_a_path();
      }
    return smooth;
  }
  [[nodiscard]] Efficiency with(std::vector<std::uint32_t> log2_copies) const {
    return {side_, wide_, std::move(log2_copies)};
  }

 private:
  std::uint64_t side_, wide_, high_;
  std::vector<Seen> seen_;
};

/// The numbers of copies for which a block's variance of a copy, over its rays, is as many squares of the copies as the
/// image's variance over its rays, which the copies make: a fixed point.
std::vector<std::uint32_t> worthwhile_copies(const std::vector<Seen>& blocks, const Seen& image) {
  const double count = static_cast<double>(blocks.size());
  // A sampler that fills its strata leaves less than the variance that copies have by themselves.
  const double own = std::clamp((image.one - image.all) * kCopies / (kCopies - 1), 0.0, image.one);
  const double left = image.within > 0 ? own / image.within : 0.0;
  std::vector<double> copies(blocks.size(), 1.0);
  for (int turn = 0; turn < 16; ++turn) {
    double variance = (image.one - own) / image.paths * count, rays = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      variance += left * blocks[i].within / copies[i];
      rays += blocks[i].rays_shared + blocks[i].rays_copy * copies[i];
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double of_copy = left * blocks[i].within;
      const double worth = of_copy > 0 ? std::sqrt(of_copy / blocks[i].rays_copy * rays / variance) : 1.0;
      copies[i] = std::clamp(worth, 1.0, static_cast<double>(1U << Efficiency::kMostLog2));
    }
  }
  std::vector<std::uint32_t> log2_copies;
  for (const double n : copies) log2_copies.push_back(static_cast<std::uint32_t>(std::lround(std::log2(n))));
  return log2_copies;
}

}  // namespace

Efficiency learn_efficiency(const Scene& scene, const Settings& given, unsigned threads) {
  scene.lights.prepare(given.lights, given.environment);
  const Efficiency split = Efficiency::uniform(kLog2Copies);
  Settings settings = given;
  settings.efficiency = &split;
  const std::uint64_t width = scene.film.width, pixels = width * scene.film.height;
  const std::uint64_t paths = std::clamp(pixels / kPixelsAPath, kLeastPaths, kMostPaths);
  std::vector<PilotPixel> pilot(paths / (kReplicates * kSamples));
  const auto place = [&](std::size_t i) { return mix64(kSeed + i) % pixels; };
  std::atomic<std::size_t> next{0};
  on_threads(threads, [&](unsigned) {
    for (std::size_t i = next++; i < pilot.size(); i = next++)
      pilot[i] = render_pixel({scene, settings, kSeed + i, {}, 0, 0}, place(i) % width, place(i) / width);
  });
  double mean = 0, rendered = 0;
  for (const PilotPixel& p : pilot) mean += (p.mean[0] + p.mean[1] + p.mean[2]) / 3 * p.paths, rendered += p.paths;
  if (!(mean > 0)) return Efficiency::uniform(0);
  Seen image;
  Blocks blocks(scene.film, pilot.size());
  for (std::size_t i = 0; i < pilot.size(); ++i) {
    const Seen s = seen(pilot[i], mean / rendered);
    image += s;
    blocks.add(place(i) % width, place(i) / width, s);
  }
  return blocks.with(worthwhile_copies(blocks.smoothed(image), image));
}

}  // namespace equaltime
