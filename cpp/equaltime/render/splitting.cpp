#include "equaltime/render/splitting.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"
#include "equaltime/render/splitting_pilot.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

namespace {

constexpr double kPixelsABlock = 2;  // mean number of pilot pixels per block
constexpr double kImagePixels = 4;   // weight of the whole image in a block's mean, in pilot pixels
constexpr double kMostShare = 0.05;  // largest fraction of a sum over the pilot that one pixel may contribute
constexpr std::size_t kParts = 8;    // of the pilot; each part is judged with the copies that the others chose
constexpr double kCopies = SplittingPilot::kCopies;
/// Pixels of the smallest film for which splitting is decided automatically. The pilot of a smaller film contains too
/// few of the noisiest pixels, such as the edges of emitters.
constexpr std::uint64_t kLeastFilmPixels = 65536;
/// Time per ray of kernels with splitting, relative to kernels without: median of 13 scenes (1.02 to 1.24).
constexpr double kCopyRay = 1.1;
/// Variance × rays with splitting and the lattice, relative to the pilot's prediction: median of 5 scenes (0.87
/// to 1.01) at 64 samples a pixel. The pilot cannot see the lattice's gain, because its few samples do not fill a
/// lattice.
constexpr double kLattice = 0.92;

/// Largest t such that min(value, t) of any pixel is at most kMostShare × (`beside` + the sum of min(value, t)). The
/// bound keeps a rare bright path in one pilot pixel from deciding for the whole image.
double bound_of(const std::vector<PilotPixel>& pixels, double PilotPixel::*value, double beside) {
  double t = 0;
  for (const PilotPixel& p : pixels) t = std::max(t, p.*value);
  for (int turn = 0; turn < 64; ++turn) {
    double sum = beside;
    for (const PilotPixel& p : pixels) sum += std::min(p.*value, t);
    t = std::min(t, kMostShare * sum);
  }
  return t;
}

void bound(std::vector<PilotPixel>& pixels, double PilotPixel::*value, double beside = 0) {
  const double most = bound_of(pixels, value, beside);
  for (PilotPixel& p : pixels) p.*value = std::min(p.*value, most);
}

/// Bounds each quantity of each pixel. Emitters that the camera sees are noisy in few pixels, at their edges, so their
/// variance is bounded relative to the whole variance. Relative to its own sum, almost nothing of it would remain.
void bound(std::vector<PilotPixel>& pixels) {
  for (const auto value : {&PilotPixel::one, &PilotPixel::all, &PilotPixel::within}) bound(pixels, value);
  double scattered = 0;
  for (const PilotPixel& p : pixels) scattered += p.one;
  bound(pixels, &PilotPixel::seen, scattered);
}

/// Sums over pixels.
struct Seen {
  double pixels = 0, variance = 0;  // with one copy
  double scattered = 0, own = 0;    // part of `variance`: of scattered light; removed by infinitely many copies
  double deviation = 0;             // among copies; a few pixels would dominate a sum of variances
  double rays_shared = 0, rays_copy = 0;

  Seen() = default;
  explicit Seen(const PilotPixel& p) noexcept
      : pixels(1),
        variance(p.seen + p.one),
        scattered(p.one),
        own((p.one - p.all) * kCopies / (kCopies - 1)),
        deviation(std::sqrt(p.within)),
        rays_shared(p.rays_shared),
        rays_copy(p.rays_copy) {}
  void add(const Seen& s, double weight = 1) noexcept {
    pixels += weight * s.pixels, variance += weight * s.variance, scattered += weight * s.scattered;
    own += weight * s.own, deviation += weight * s.deviation;
    rays_shared += weight * s.rays_shared, rays_copy += weight * s.rays_copy;
  }
};

/// Blocks of the film with about kPixelsABlock pilot pixels each.
class Blocks {
 public:
  Blocks(const FilmDescription& film, std::size_t pilot_pixels)
      : side_(static_cast<std::uint64_t>(
            std::ceil(std::sqrt(kPixelsABlock * film.width * film.height / static_cast<double>(pilot_pixels))))),
        wide_((film.width + side_ - 1) / side_),
        high_((film.height + side_ - 1) / side_),
        seen_(wide_ * high_) {}

  void add(const PilotPixel& p) noexcept { seen_[p.y / side_ * wide_ + p.x / side_].add(Seen(p)); }

  /// Means in each block, as seen there, in its neighbours and in the image.
  [[nodiscard]] std::vector<Seen> smoothed(const Seen& image) const {
    std::vector<Seen> smooth(seen_.size());
    for (std::uint64_t y = 0; y < high_; ++y)
      for (std::uint64_t x = 0; x < wide_; ++x) {
        Seen sum;
        sum.add(image, kImagePixels / image.pixels);
        for (std::uint64_t v = y - (y > 0); v < std::min(y + 2, high_); ++v)
          for (std::uint64_t u = x - (x > 0); u < std::min(x + 2, wide_); ++u) sum.add(seen_[v * wide_ + u]);
        smooth[y * wide_ + x].add(sum, 1 / sum.pixels);
      }
    return smooth;
  }
  [[nodiscard]] SplittingMap with(std::vector<std::uint32_t> log2_copies) const {
    return {side_, wide_, std::move(log2_copies)};
  }

 private:
  std::uint64_t side_, wide_, high_;
  std::vector<Seen> seen_;
};

/// Variance of a single copy in each block, in proportion to the squared deviation among copies. A stratified sampler
/// has less variance than the deviation among copies suggests, so the variances are scaled: their sum is the variance
/// that splitting removes.
std::vector<double> variances_of_copy(const std::vector<Seen>& blocks, const Seen& image) {
  std::vector<double> variances;
  double sum = 0;
  for (const Seen& block : blocks) sum += variances.emplace_back(square(block.deviation));
  const double own = std::clamp(image.own, 0.0, image.scattered) / image.pixels;
  for (double& variance : variances) variance *= sum > 0 ? own / sum * static_cast<double>(blocks.size()) : 0;
  return variances;
}

/// Returns each block's number of copies n = sqrt((v / r) / (V / R)), as a power of two. v and r are the variance and
/// rays of one copy in the block. V and R are those of the image; they depend on all n, so the loop iterates to a fixed
/// point.
std::vector<std::uint32_t> worthwhile_copies(const std::vector<Seen>& blocks, const Seen& image) {
  const std::vector<double> of_copy = variances_of_copy(blocks, image);
  double shared = image.variance / image.pixels * static_cast<double>(blocks.size());
  for (const double variance : of_copy) shared -= variance;
  std::vector<double> copies(blocks.size(), 1.0);
  for (int turn = 0; turn < 16; ++turn) {
    double variance = shared, rays = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      variance += of_copy[i] / copies[i];
      rays += blocks[i].rays_shared + blocks[i].rays_copy * copies[i];
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double worth = of_copy[i] > 0 ? std::sqrt(of_copy[i] / blocks[i].rays_copy * rays / variance) : 1.0;
      copies[i] = std::clamp(worth, 1.0, static_cast<double>(1U << SplittingMap::kMostLog2));
    }
  }
  std::vector<std::uint32_t> log2_copies;
  for (const double n : copies)
    log2_copies.push_back(static_cast<std::uint32_t>(std::lround(elementary::log(n) / std::numbers::ln2)));
  return log2_copies;
}

/// Sums of variance and rays, without and with splitting. The variance predicted for more copies than the pilot's has a
/// lower bound, because it is a difference of noisy sums.
struct Judged {
  double variance = 0, saved = 0, least = 0, rays = 0, rays_split = 0;

  void add(const PilotPixel& p, const SplittingMap& map) noexcept {
    const Seen s(p);
    const double copies = 1U << map.log2_copies(p.x, p.y);
    variance += s.variance, saved += s.own * (1 - 1 / copies);
    least += p.seen + p.all * std::min(1.0, kCopies / copies);
    rays += s.rays_shared + s.rays_copy, rays_split += s.rays_shared + s.rays_copy * copies;
  }
  [[nodiscard]] double log_ratio() const noexcept {
    const double left = std::max(variance - saved, std::min(least, variance));
    return left > 0 ? elementary::log(left / variance * rays_split / rays) : 0.0;
  }
};

/// Bounded pixels of a pilot with their parts. A square stays in one part, because its pixels share their mean.
struct Parts {
  std::vector<PilotPixel> pixels;
  std::vector<std::size_t> part;

  explicit Parts(const SplittingPilot& pilot) {
    for (std::size_t i = 0; i < pilot.squares.size(); ++i)
      for (const PilotPixel& p : pilot.squares[i]) pixels.push_back(p), part.push_back(i % kParts);
    bound(pixels);
  }
  /// Numbers of copies chosen from all parts but `left_out`; from all parts if it is kParts.
  [[nodiscard]] SplittingMap fitted(const FilmDescription& film, std::size_t left_out) const {
    Seen image;
    Blocks blocks(film, pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i)
      if (part[i] != left_out) image.add(Seen(pixels[i])), blocks.add(pixels[i]);
    if (!(image.pixels > 0)) return SplittingMap::uniform(0);
    return blocks.with(worthwhile_copies(blocks.smoothed(image), image));
  }
};

}  // namespace

Splitting estimate_splitting(const Scene& scene, const Settings& settings, unsigned threads, Stop& stop) {
  const SplittingPilot pilot = render_splitting_pilot(scene, settings, threads, stop);
  Splitting splitting;
  splitting.rays = pilot.rays, splitting.shadow_rays = pilot.shadow_rays;
  const Parts parts(pilot);
  if (parts.pixels.empty()) return splitting;
  Judged judged;
  for (std::size_t own = 0; own < kParts; ++own) {
    const SplittingMap by_others = parts.fitted(scene.camera.film, own);
    for (std::size_t i = 0; i < parts.pixels.size(); ++i)
      if (parts.part[i] == own) judged.add(parts.pixels[i], by_others);
  }
  splitting.log_ratio = judged.log_ratio();
  splitting.splitting_map = parts.fitted(scene.camera.film, kParts);
  return splitting;
}

Settings RouletteDecision::applied(Settings settings) const noexcept {
  settings.roulette = roulette;
  if (splitting_map) settings.splitting_map = splitting_map.get();
  return settings;
}

bool is_undecided(const Settings& settings) noexcept {
  return settings.roulette == Roulette::automatic ||
         (settings.roulette == Roulette::efficiency && settings.splitting_map == nullptr);
}

RouletteDecision decide_roulette(const Scene& scene, const Settings& settings, unsigned threads, Stop& stop) {
  RouletteDecision decision;
  decision.roulette = settings.roulette == Roulette::automatic ? Roulette::throughput : settings.roulette;
  const bool fixed = settings.roulette != Roulette::automatic;
  const bool can_pay = !replaces_bsdf_sampling(settings.technique) &&
                       std::uint64_t{scene.camera.film.width} * scene.camera.film.height >= kLeastFilmPixels;
  if (!is_undecided(settings) || !(fixed || can_pay)) return decision;
  Splitting found = estimate_splitting(scene, settings, threads, stop);
  decision.log_ratio = found.log_ratio, decision.rays = found.rays, decision.shadow_rays = found.shadow_rays;
  const double more = settings.sampler == SamplerKind::lattice ? kCopyRay * kLattice : kCopyRay;
  if (!fixed && found.log_ratio + elementary::log(more) >= 0) return decision;
  decision.roulette = Roulette::efficiency;
  decision.splitting_map = std::make_shared<const SplittingMap>(std::move(found.splitting_map));
  return decision;
}

}  // namespace equaltime
