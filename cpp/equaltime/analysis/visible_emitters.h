// Emitters as the camera sees them, found from the emitters' side: one that fills a thousandth of a pixel is missed by
// most renders of a few hundred samples, which do not know what they miss.
#pragma once

#include <cstdint>
#include <map>

#include "equaltime/render/renderer.h"

namespace equaltime {

/// Radiance that a pixel sees directly from emitters.
struct EmittersOfPixel {
  double mean[3] = {}, mean_square[3] = {};  // of each channel, in the user's units
  std::uint32_t points = 0;                  // of emitters, of which these are made

  /// One more point, whose radiance in the user's units is `scale` times L, and whose weight in the means is `weight`.
  void add(const Spectrum& L, double scale, double weight) noexcept {
    ++points;
    const float channels[3] = {L.r, L.g, L.b};
    for (int c = 0; c < 3; ++c) {
      const double value = static_cast<double>(channels[c]) * scale;
      mean[c] += weight * value;
      mean_square[c] += weight * value * value;
    }
  }
};

/// By points that are drawn on emitters, and looked at by the rays that pinholes and lenses would send there: pixels
/// (y * width + x of the crop, or of the whole film) that see some. None for other cameras, and those that move.
[[nodiscard]] std::map<std::uint32_t, EmittersOfPixel> find_visible_emitters(const Scene& scene, Settings settings,
                                                                             std::uint64_t seed, std::uint64_t points,
                                                                             bool whole_film = false);

}  // namespace equaltime
