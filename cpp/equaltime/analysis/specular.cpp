#include "equaltime/analysis/specular.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

/// Per steradian: a sampled direction of at least this density counts as specular. A microfacet lobe of roughness 0.02
/// peaks at 200.
constexpr float kSpecularDensity = 100;
/// A chain of more vertices carries little light.
constexpr int kLongestChain = 16;
/// Chains a pixel: least that tell whether it sees an emitter; least and most that tell what it sees.
constexpr std::uint64_t kScouts = 4, kFewest = 16, kMost = 4096;
/// Number of squares of the film, in which one chain finds the kind of the first vertex; largest side in pixels.
constexpr std::size_t kSquares = 4096, kLargestSquare = 4;
/// A large film gets a chain for this number of pixels.
constexpr std::uint64_t kPixelsPerChain = 4;
constexpr std::size_t kChunk = 16;  // pixels that a worker takes at once

enum class VertexKind : std::uint8_t { specular, straight, other };

/// The kind of a vertex, by where the path goes on; thin glass that is passed straight is as good as none.
VertexKind kind_of(const event::DirectionSampled& at) noexcept {
  if (!at.scattered) return VertexKind::other;
  if (at.scatterer.is_thin() && !at.scattered->above) return VertexKind::straight;
  return at.scattered->delta || at.scattered->pdf > kSpecularDensity ? VertexKind::specular : VertexKind::other;
}

/// The vertex at which an observer leaves a path: the first specular one, or the first of another kind.
enum class Leaves : std::uint8_t { at_specular, at_other };

/// Follows a path until it leaves it. Gathers the light of emitters that are met beyond a specular vertex.
template <Leaves where>
class ChainObserver : public PathObserver {
 public:
  void on(const event::PathStarted& path) noexcept {
    left_ = specular_ = false, density_ = 0, radiance_ = {}, weight_ = path.filter_weight;
  }
  void on(const event::RayTraced& traced) noexcept { time_ = traced.time; }
  void on(const event::EmissionAdded& added) noexcept {
    if (specular_) radiance_ += added.L;
  }
  void on(const event::DirectionSampled& at) noexcept {
    const VertexKind kind = kind_of(at);
    specular_ = specular_ || kind == VertexKind::specular;
    left_ = kind == (where == Leaves::at_specular ? VertexKind::specular : VertexKind::other);
    place_ = at.it.anchor.p;
    density_ = kind == VertexKind::specular && !at.scattered->delta ? at.scattered->pdf : 0;
  }
  [[nodiscard]] bool stops_path() const noexcept { return left_; }

  /// Whether the path has met a specular vertex, and where it was left.
  [[nodiscard]] bool specular() const noexcept { return specular_; }
  [[nodiscard]] const Vec3f& place() const noexcept { return place_; }
  /// Per steradian, of the direction that the last vertex drew; 0 if the vertex is not specular or the direction is
  /// discrete.
  [[nodiscard]] float density() const noexcept { return density_; }

  [[nodiscard]] float time() const noexcept { return time_; }
  /// Radiance of the emitters, with the weight of the path's place under the pixel filter.
  [[nodiscard]] Spectrum radiance() const noexcept { return radiance_ * weight_; }

 private:
  bool left_ = false, specular_ = false;
  Spectrum radiance_;
  float weight_ = 1, time_ = 0;
  Vec3f place_;
  float density_ = 0;
};

using FocusObserver = ChainObserver<Leaves::at_specular>;
using MirrorObserver = ChainObserver<Leaves::at_other>;

/// Lights without extent are left out: only samples of lights find them, and chains take none.
constexpr Effects kChainEffects = [] {
  Effects effects = kAllEffects;
  effects.point_lights = false;
  return effects;
}();

/// Paths that scatter by the BSDF alone and are never ended by roulette, of a scene whose lights are ready.
struct Chains {
  const Scene& scene;
  Settings settings;
  std::uint64_t seed;  // no render's: what chains find must not depend on what samples of the film did
  unsigned threads;

  Chains(const Scene& s, Settings of_render, const RenderOptions& options)
      : scene(s), settings(of_render), seed(options.seed ^ kGolden), threads(thread_count(options.threads)) {
    settings.technique = Technique::bsdf;
    settings.light_selection = LightSelection::power;
    settings.roulette = Roulette::none;
    settings.sampler = SamplerKind::sobol;
    settings.max_depth = std::min(settings.max_depth, kLongestChain);
    scene.lights.prepare(settings.light_selection, settings.environment_sampling);
  }

  [[nodiscard]] std::size_t pixels() const noexcept {
    return std::size_t{scene.camera.film.crop_width} * scene.camera.film.crop_height;
  }
  template <Observer O>
  void sample(std::size_t pixel, std::uint64_t index, O& observer) const {
    const std::size_t x = pixel % scene.camera.film.crop_width, y = pixel / scene.camera.film.crop_width;
    film_sample(x + scene.camera.film.crop_x, y + scene.camera.film.crop_y, index, observer);
  }
  /// Traces one sample of a pixel, whose place is in the whole film.
  template <Observer O>
  void film_sample(std::size_t x, std::size_t y, std::uint64_t index, O& observer) const {
    const BlockTask task{scene, settings, seed, {}, 0, 1, 1};
    (void)sample_film_pixel<kChainEffects>(task, x, y, index, observer);
  }
};

/// Calls work(i, observer) for all i below `count`; each thread has an observer of its own.
template <Observer O, class Work>
void for_each(std::size_t count, unsigned threads, const Work& work) {
  run_items(count, kChunk, threads,
            [&] { return [&work, observer = O()](std::size_t i) mutable { work(i, observer); }; });
}

using Pixels = std::vector<std::uint32_t>;  // y * width + x of the crop, ascending
using Found = std::map<std::uint32_t, EmittersOfPixel>;

/// Returns the pixels whose first vertex is specular. One chain from the middle of a square decides for its pixels.
Pixels mirrors_of(const Chains& chains) {
  const std::size_t width = chains.scene.camera.film.crop_width, height = chains.scene.camera.film.crop_height;
  const auto fitting = static_cast<std::size_t>(std::sqrt(chains.pixels() / kSquares));
  const std::size_t side = std::clamp<std::size_t>(fitting, 1, kLargestSquare);
  const std::size_t columns = (width + side - 1) / side, rows = (height + side - 1) / side;
  std::vector<std::uint8_t> specular(columns * rows);
  for_each<MirrorObserver>(specular.size(), chains.threads, [&](std::size_t i, MirrorObserver& observer) {
    const std::size_t x = std::min(i % columns * side + side / 2, width - 1);
    const std::size_t y = std::min(i / columns * side + side / 2, height - 1);
    chains.sample(y * width + x, kMost, observer);  // no search for emitters uses this sample
    specular[i] = observer.specular() ? 1 : 0;
  });
  Pixels mirrors;
  for (std::size_t i = 0; i < chains.pixels(); ++i)
    if (specular[i / width / side * columns + i % width / side] != 0) mirrors.push_back(static_cast<std::uint32_t>(i));
  return mirrors;
}

/// Returns the emitters that pixels see, found by `all` chains from sample `first` on. The pixels share the chains
/// evenly; with fewer than `least` a pixel, nothing is found.
Found emitters_in(const Chains& chains, const Pixels& pixels, std::uint64_t all, std::uint64_t least,
                  std::uint64_t first) {
  const std::uint64_t each = pixels.empty() ? 0 : std::min(all / pixels.size(), kMost);
  if (each < least) return {};
  const double scale = chains.scene.normalization.world_radiance_scale(), weight = 1.0 / static_cast<double>(each);
  std::vector<EmittersOfPixel> emitters(pixels.size());
  for_each<MirrorObserver>(pixels.size(), chains.threads, [&](std::size_t i, MirrorObserver& observer) {
    for (std::uint64_t index = 0; index < each; ++index) {
      chains.sample(pixels[i], first + index, observer);
      const Spectrum L = observer.radiance();
      if (!L.is_black()) emitters[i].add(L, scale, weight);
    }
  });
  Found found;
  for (std::size_t i = 0; i < pixels.size(); ++i)
    if (emitters[i].points > 0) found.emplace(pixels[i], emitters[i]);
  return found;
}

/// Returns the pixels of `found` with the eight pixels around each.
Pixels with_neighbours(const Chains& chains, const Found& found) {
  const std::size_t width = chains.scene.camera.film.crop_width, height = chains.scene.camera.film.crop_height;
  std::set<std::uint32_t> all;
  for (const auto& [pixel, emitters] : found) {
    const std::size_t x = pixel % width, y = pixel / width;
    for (std::size_t v = y - std::min<std::size_t>(y, 1); v < std::min(y + 2, height); ++v)
      for (std::size_t u = x - std::min<std::size_t>(x, 1); u < std::min(x + 2, width); ++u)
        all.insert(static_cast<std::uint32_t>(v * width + u));
  }
  return {all.begin(), all.end()};
}

}  // namespace

FocusedLight focused_light(const Scene& scene, const Settings& settings, const RenderOptions& options,
                           std::uint64_t paths, bool whole_film) {
  const Chains chains(scene, settings, options);
  const std::size_t width = scene.camera.film.width, film_pixels = width * scene.camera.film.height;
  struct Seen {
    bool vertex = false;
    double once = 0, squared = 0;
  };
  std::vector<Seen> seen(paths);
  for_each<FocusObserver>(paths, chains.threads, [&](std::size_t i, FocusObserver& observer) {
    const std::size_t pixel = i * (whole_film ? film_pixels : chains.pixels()) / paths;
    if (whole_film)
      chains.film_sample(pixel % width, pixel / width, i, observer);
    else
      chains.sample(pixel, i, observer);
    if (!observer.specular()) return;
    const Sampler sampler = Sampler::at(SamplerKind::independent, chains.seed, pixel, i, 1);
    const Point2f u = sampler.get_2d(slot(BounceDecision::light_point, 0));
    const LightSampleContext receiver{observer.place(), {}, false};
    const auto light =
        scene.lights.sample<kAllEffects>(chains.settings.light_selection, chains.settings.environment_sampling,
                                         {receiver, sampler, 0, u, observer.time()});
    seen[i].vertex = true;
    if (!light || !(light->pdf > 0)) return;
    const auto L = static_cast<double>(light->radiance.luminance()), pdf = static_cast<double>(light->pdf);
    // a narrow lobe makes a light without extent as large as itself; a discrete direction never meets such a light
    const double density = light->delta ? static_cast<double>(observer.density()) : 1;
    if (density > 0) seen[i].once = L / pdf, seen[i].squared = L * L / pdf * density;
  });
  FocusedLight found;
  double once = 0, squared = 0;
  for (const Seen& at : seen) found.vertices += at.vertex ? 1 : 0, once += at.once, squared += at.squared;
  if (!(squared > 0)) return found;
  const auto vertices = static_cast<double>(found.vertices);
  found.solid_angle = once * once / squared / vertices;
  found.radiance = once / vertices / std::numbers::pi * scene.normalization.world_radiance_scale();
  return found;
}

std::map<std::uint32_t, EmittersOfPixel> mirrored_emitters(const Scene& scene, const Settings& settings,
                                                           const RenderOptions& options, std::uint64_t samples) {
  if (scene.rules.hides_emitters) return {};
  const Chains chains(scene, settings, options);
  const std::uint64_t half = std::max<std::uint64_t>(samples, chains.pixels() / kPixelsPerChain) / 2;
  const Found scouted = emitters_in(chains, mirrors_of(chains), half, kScouts, 0);
  // Few pixels with a mirror see an emitter in it. They and their neighbours share the other half of the chains. These
  // use samples of their own, so the choice of pixels does not bias what they find.
  return emitters_in(chains, with_neighbours(chains, scouted), half, kFewest, kMost + 1);
}

}  // namespace equaltime
