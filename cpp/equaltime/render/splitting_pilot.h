// Splitting pilot: pixels rendered with one copy of each path and with four, to measure how splitting changes noise and
// ray counts. No image contains the pilot's samples. The pilot depends on the scene and the strategy, never on crop,
// seed, threads or earlier renders.
#pragma once

#include <cstdint>
#include <vector>

namespace equaltime {

struct Scene;
struct Settings;
class Stop;

/// One pixel of the pilot. Each variance is the variance of the mean of the pixel's samples, averaged over RGB. It is
/// divided by (mean around the pixel)² + (a tenth of the image's mean)², as in the error of an image.
struct PilotPixel {
  std::uint32_t x = 0, y = 0;             // in the full film
  double seen = 0;                        // of the light of emitters that the camera sees, which splitting leaves alone
  double one = 0, all = 0;                // of light that is scattered, with one copy and with all
  double within = 0;                      // among the copies of a path
  double rays_shared = 0, rays_copy = 0;  // a path, before it is split and after, of one copy
};

struct SplittingPilot {
  static constexpr std::uint32_t kLog2Copies = 2;
  static constexpr double kCopies = 1U << kLog2Copies;

  std::vector<std::vector<PilotPixel>> squares;  // neighbours stand together
  std::uint64_t rays = 0, shadow_rays = 0;       // that it took
};

/// Renders a pilot of one pixel for 64 of the film, but no fewer than 256 and no more than 4096: it takes as many rays
/// as 0.6 path a pixel of a film of a million pixels or less, which is 1 % of a render of 64 samples a pixel. Squares
/// are missing if `stop` ends it.
[[nodiscard]] SplittingPilot render_splitting_pilot(const Scene& scene, const Settings& settings, unsigned threads,
                                                    Stop& stop);

}  // namespace equaltime
