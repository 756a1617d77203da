// Replay: traces one sample of a render again with the same estimator, and keeps every factor of it. Everything is in
// normalised space and units (math/normalization.h).
#pragma once

#include <optional>
#include <vector>

#include "equaltime/scene/scene.h"
#include "equaltime/transport/gather.h"

namespace equaltime {

/// Light that a vertex receives straight from a picked light.
struct TracedLight {
  PickedLight pick;
  std::optional<LightSample<float>> sample;  // none if the light shows the vertex no front
  BsdfValue<float> bsdf;                     // towards it
  float weight = 0;                          // of MIS
  float visibility = 0;                      // fraction that reaches the vertex; not computed if the BSDF is black
  std::optional<Interaction> closest_occluder;
  Spectrum gathered;       // what it adds to the path
  Spectrum radiance = {};  // of the sample
};

/// The emitter that a ray hit.
struct TracedEmitter {
  std::uint32_t light;
  Spectrum radiance;
  float light_pdf, weight;  // of light sampling, and of MIS
  Spectrum gathered;
};

/// The sampled direction in which a path goes on.
struct TracedScattering {
  const char* bsdf;  // in Mitsuba's words
  Interaction it;    // with the frame after normal mapping
  Spectrum albedo;   // of the BSDF, for all directions together
  std::optional<ScatterSample> scattered;
  std::optional<float> survival;  // of roulette
};

/// A ray, and what happens where it ends.
struct TracedVertex {
  Ray ray;
  PreviousVertex previous;
  Spectrum beta, L;                // on arrival: throughput, and what the path has gathered before
  std::optional<Interaction> it;   // none: the ray escapes
  std::optional<Point2f> prim_uv;  // unknown on surfaces without textures; see prim_uv_at
  std::optional<TracedEmitter> emitter;
  std::optional<TracedLight> light;
  std::optional<TracedScattering> scattering;  // none where nothing is scattered: the path ends or passes straight on
  Spectrum left = {};                          // transmittance weight of the medium that the ray crossed
  bool in_medium = false;                      // the medium scattered the path here; there is no surface
  int faults = 0;          // floating-point ones from the ray's sending on, of <cfenv>; the first's, also before
  std::size_t length = 1;  // of the path, in rays
  std::optional<std::size_t> from = {};  // the vertex that the ray left; none at the camera
};

/// Why a path has no more vertices.
enum class PathEnd : std::uint8_t { escapes, depth, absorbed, no_direction, black, not_finite, roulette };

struct Replay {
  float filter_weight;                 // of its place under the pixel's filter
  Spectrum radiance;                   // the sample, the filter's weight included: what the render added to its film
  std::vector<TracedVertex> vertices;  // at least one; copies of a path that was split come one after the other
  PathEnd end;                         // of the last copy
};

/// Sample `index` of the pixel (x, y) of the crop, bit by bit as any kernel that covers the scene renders it.
[[nodiscard]] Replay replay(const Scene& scene, const Settings& settings, std::uint64_t seed, std::uint32_t x,
                            std::uint32_t y, std::uint64_t index, std::uint32_t nets);

/// The shape that an area light is, or the triangle of a mesh that is one; kNone for other lights.
[[nodiscard]] std::uint32_t shape_of_light(const Scene& scene, std::uint32_t light) noexcept;

}  // namespace equaltime
