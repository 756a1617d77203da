// Alpha of each pixel: the fraction of its camera rays that a surface or medium stops. The environment and hidden
// emitters stop none. Masks and null surfaces stop the fraction that they do not transmit.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "equaltime/render/renderer.h"

namespace equaltime {

/// The alpha of every pixel of the crop (height, width), row by row: a mean over the first `samples` camera rays of a
/// render with the same options, weighted by the size of the reconstruction filter. It is exactly 0 where none meets
/// anything, and exactly 1 where all are stopped. `poll` is called about every 50 ms by the calling thread and ends it
/// all by throwing.
[[nodiscard]] std::vector<float> alpha(std::shared_ptr<const Scene> scene, const Settings& settings,
                                       const RenderOptions& options, std::uint64_t samples, const Poll& poll = {});

}  // namespace equaltime
