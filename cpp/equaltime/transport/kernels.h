// Kernels: the compiled instantiations of the estimator, and the choice among them by the superset rule.
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

/// A sample that came out NaN or infinite, as replay needs it; x, y within the crop.
struct NonFinite {
  std::uint32_t x, y;
  std::uint64_t index;
};

/// What brings every pixel of a block from `first` samples to `last`, which are averages where the schedule is uneven.
struct BlockTask {
  const Scene& scene;
  const Settings& settings;
  std::uint64_t seed;
  PixelBlock block;
  std::uint64_t first, last;
  std::uint32_t nets = 2;                    // of each pixel: sample i belongs to net i mod nets
  const SampleSchedule* schedule = nullptr;  // none: all pixels alike
  std::uint64_t* pixel_rays = nullptr;       // if anybody asks, one for each of the film
  SecondNets* second = nullptr;              // if some pixels have a second net, not in the film
};

/// Renders a block into the film. Non-finite samples are logged and kept out of the film. If the counter gives a path
/// up, the block stays unfinished.
using Kernel = void (*)(const BlockTask&, Film&, RayCounter&, SampleLog<NonFinite>&);
/// The same samples without a film, keeping their rays.
using RecordingKernel = void (*)(const BlockTask&, RayRecorder&);

struct KernelRow {
  Effects effects;
  Kernel render;
  RecordingKernel record;
};

/// The cheapest compiled kernel that covers the need. The choice changes speed, never a bit of the image.
[[nodiscard]] const KernelRow& choose_kernel(const Effects& need) noexcept;
/// All of them, cheapest first; the last covers everything.
[[nodiscard]] const std::vector<KernelRow>& kernel_rows() noexcept;
/// The effects by name, joined with +; "diffuse meshes" if there are none.
[[nodiscard]] std::string kernel_name(const Effects& effects);

}  // namespace equaltime
