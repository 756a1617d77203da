// What a pixel whose samples were all black could have received: its paths once more, with nothing between a vertex and
// the light that it aims at. Zero means that no light faces what the path met; more is a bound of what may be hidden.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "equaltime/render/renderer.h"

namespace equaltime {

/// For each of these pixels (y * width + x of the crop) the first sample of a render with the same options, by MIS
/// and the light tree whatever the settings say: three channels a pixel, in the user's units.
[[nodiscard]] std::vector<double> unoccluded_direct_light(std::shared_ptr<const Scene> scene, Settings settings,
                                                          const RenderOptions& options,
                                                          std::span<const std::uint32_t> pixels);

}  // namespace equaltime
