// The picture of a texture: how its radiance is spread over the unit square. Cells lie between the lines along which a
// bitmap's interpolation changes, so that each has its exact integral, and one whose radiance is not all black is never
// left out; of a texture without such lines, or with too many, the square is cut evenly, and a share of the points is
// spread over all of it.
#pragma once

#include "equaltime/sampling/image_distribution.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

/// The picture of the mean of the texture's colours, each multiplied by `color`.
[[nodiscard]] ImageDistribution picture_of(const Texture& texture, const Spectrum& color);

}  // namespace equaltime
