#include "equaltime/analysis/unoccluded_light.h"

#include <algorithm>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

constexpr std::size_t kChunk = 64;  // pixels that a worker takes at once

/// Traces no shadow rays: every light is visible.
struct WithoutShadows : PathObserver {
  static constexpr bool sees_shadows = false;
};

}  // namespace

std::vector<double> radiance_without_occlusion(std::shared_ptr<const Scene> scene, Settings settings,
                                               const RenderOptions& options, std::span<const std::uint32_t> pixels) {
  // Another technique or light selection may find light that the render's own hardly ever finds.
  settings.technique = Technique::mis;
  settings.light_selection = LightSelection::tree;
  const Renderer renderer(scene, settings, options);  // prepares the lights
  const std::uint32_t width = scene->camera.film.crop_width;
  const double scale = scene->normalization.world_radiance_scale();
  std::vector<double> found(3 * pixels.size());
  run_items(pixels.size(), kChunk, renderer.threads(), [&] {
    return [&, observer = WithoutShadows()](std::size_t i) mutable {
      const std::uint32_t x = pixels[i] % width, y = pixels[i] / width;
      const BlockTask task{*scene, settings, options.seed, {x, y, x + 1, y + 1}, 0, 1, options.nets};
      const Spectrum L = sample_pixel<kAllEffects>(task, x, y, 0, observer);
      const float channels[3] = {L.r, L.g, L.b};
      for (std::size_t c = 0; c < 3; ++c) found[3 * i + c] = std::max(0.0, static_cast<double>(channels[c]) * scale);
    };
  });
  return found;
}

}  // namespace equaltime
