// Kernel: the estimator compiled for a set of effects. A render takes the cheapest one that covers its scene's effects.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/film/film.h"
#include "equaltime/film/sample_log.h"
#include "equaltime/film/schedule.h"
#include "equaltime/film/second_nets.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/observer.h"
#include "equaltime/transport/settings.h"

namespace equaltime {

/// Pixels [x0, x1) × [y0, y1) of the crop.
struct PixelBlock {
  std::uint32_t x0, y0, x1, y1;
};

/// A sample whose radiance is NaN or infinite; x and y are within the crop.
struct NonFinite {
  std::uint32_t x, y;
  std::uint64_t index;
};

/// Work order: render samples `first` to `last` - 1 of each pixel of a block. With a schedule, `first` and `last` are
/// averages over the image, and each pixel has its own numbers.
struct BlockTask {
  const Scene& scene;
  const Settings& settings;
  std::uint64_t seed;
  PixelBlock block;
  std::uint64_t first, last;
  std::uint32_t nets = 2;                    // per pixel: sample i belongs to net i mod nets
  const SampleSchedule* schedule = nullptr;  // null: all pixels get the same number of samples
  std::uint64_t* pixel_rays = nullptr;       // null, or a counter for each pixel of the film
  SecondNets* second = nullptr;              // null, or the pixels that have a second net, outside the film
};

/// Renders a block into the film. Non-finite samples are logged and kept out of the film. If the counter gives up a
/// path, the block stays unfinished.
using RenderBlock = void (*)(const BlockTask&, Film&, RayCounter&, SampleLog<NonFinite>&);
/// Traces the same samples, and records their rays instead of their radiance.
using RecordBlock = void (*)(const BlockTask&, RayRecorder&);

struct Kernel {
  Effects effects;
  RenderBlock render;
  RecordBlock record;
};

/// The cheapest compiled kernel that covers these effects. The choice changes speed, never a bit of the image.
[[nodiscard]] const Kernel& choose_kernel(const Effects& need) noexcept;
/// All compiled kernels, cheapest first. The last covers all effects.
[[nodiscard]] const std::vector<Kernel>& compiled_kernels() noexcept;
/// Names of the effects, joined with +; "diffuse meshes" if there are none.
[[nodiscard]] std::string kernel_name(const Effects& effects);

}  // namespace equaltime
