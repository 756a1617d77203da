// Radiance without occlusion, for pixels whose samples were all black: their paths are traced again without shadow
// rays. Zero means that no light faces any vertex. A positive value estimates how much light occluders may hide.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equaltime/render/renderer.h"

namespace equaltime {

/// For each of these pixels (y * width + x of the crop) the first sample of a render with the same options, by MIS
/// and the light tree whatever the settings say: three channels a pixel, in the user's units. Light sampled at all
/// vertices and emission count; a sample that is not finite is 0.
[[nodiscard]] std::vector<double> radiance_without_occlusion(std::shared_ptr<const Scene> scene, Settings settings,
                                                             const RenderOptions& options,
                                                             std::span<const std::uint32_t> pixels);

}  // namespace equaltime
