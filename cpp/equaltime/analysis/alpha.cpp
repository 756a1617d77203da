#include "equaltime/analysis/alpha.h"

#include <algorithm>
#include <cmath>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/transport/hidden_emitters.h"
#include "equaltime/transport/sample_pixel.h"
#include "equaltime/transport/shadow.h"
#include "equaltime/transport/volume.h"

namespace equaltime {

namespace {

/// Fraction of a camera ray's light that is stopped, in [0, 1]. Scattering in media is sampled.
template <Effects E>
double opacity(const Scene& scene, Ray ray, const Sampler& sampler, float time) noexcept {
  Spectrum through(1);
  PathMediumState<E> media(scene, ray, time);
  const HiddenEmitters<E> hidden_emitters(true);
  for (std::uint32_t crossed = 0;; ++crossed) {
    auto hit = scene.geometry.closest<E>(ray, time);
    if (media.sample_distance(scene, ray, sampler, crossed, through, hit) != nullptr) return 1;
    const Optional<Interaction>& it = hit.it;
    if (!it) return 1 - static_cast<double>(through.mean());
    if (!media.here().hides(scene.geometry, it->shape) && !hidden_emitters.skips(scene, *it, 1)) {
      const std::uint32_t material = scene.geometry.material(*it);
      if (material == kNone) return 1;
      through *= surface_transmittance<E>(scene, material, *it, false, time);
      if (through.is_black()) return 1;
    }
    ray = it->spawn(-it->wo, false);
    media.leave(scene, *it, false);
  }
}

}  // namespace

std::vector<float> alpha(std::shared_ptr<const Scene> scene, const Settings& settings, const RenderOptions& options,
                         std::uint64_t samples, const Poll& poll) {
  const Renderer renderer(scene, settings, options);
  const std::size_t width = scene->camera.film.crop_width;
  std::vector<float> found(width * scene->camera.film.crop_height);
  const std::vector<PixelBlock> blocks = renderer.blocks();
  const auto worker = [&](std::size_t i) {
    const PixelBlock& block = blocks[i];
    const BlockTask task{*scene, settings, options.seed, block, 0, samples, options.nets};
    for (std::uint32_t y = block.y0; y < block.y1; ++y)
      for (std::uint32_t x = block.x0; x < block.x1; ++x) {
        const std::uint32_t px = x + scene->camera.film.crop_x, py = y + scene->camera.film.crop_y;
        double stopped = 0, weights = 0;
        for (std::uint64_t s = 0; s < samples; ++s) {
          const FilmSample begin(task, px, py, s);
          const float time = begin.time<kAllEffects>();
          const Ray ray = begin.ray<kAllEffects>(*scene, px, py, time);
          const double weight = std::abs(static_cast<double>(begin.offset.weight));  // so that no alpha is above 1
          stopped += weight * opacity<kAllEffects>(*scene, ray, begin.sampler, time), weights += weight;
        }
        found[width * y + x] = static_cast<float>(stopped / weights);
      }
  };
  run_blocks(
      blocks.size(), renderer.threads(), [&] { return worker; }, poll);
  return found;
}

}  // namespace equaltime
