// Effects of specular surfaces, measured before a render: the emitters that pixels see in mirrors and through glass,
// and the smallest emitters that such surfaces may focus. Chains of specular vertices alone are followed: a vertex is
// specular if the direction that its BSDF draws is discrete, or nearly so.
#pragma once

#include <cstdint>
#include <map>

#include "equaltime/analysis/visible_emitters.h"
#include "equaltime/render/renderer.h"

namespace equaltime {

/// The light of emitters at specular vertices that paths from the camera meet, as if nothing stood between.
struct FocusedLight {
  std::uint64_t vertices = 0;  // specular ones that were met, at most one a path
  double radiance = 0;         // mean over the solid angle of a sphere, times that angle, over pi: user's units
  double solid_angle = 0;  // steradians, effective: (∫L dω)² / ∫L² dω; 0 if there is no light. A light without
                           // extent is as large as the lobe of the vertex; it has no light for a discrete direction
};

/// Traces `paths` paths, spread evenly over the crop or over the whole film.
[[nodiscard]] FocusedLight focused_light(const Scene& scene, const Settings& settings, const RenderOptions& options,
                                         std::uint64_t paths, bool whole_film = false);

/// Returns the emitters that pixels (y * width + x of the crop) see by specular chains. Half of `samples` chains search
/// the pixels whose first vertex is specular. The other half looks again at pixels that see an emitter, and at their
/// neighbours. A large film gets more chains: one for four pixels. Nothing is found if the first half has fewer than 4
/// chains a pixel, if the second has fewer than 16, or if emitters are hidden.
[[nodiscard]] std::map<std::uint32_t, EmittersOfPixel> mirrored_emitters(const Scene& scene, const Settings& settings,
                                                                         const RenderOptions& options,
                                                                         std::uint64_t samples);

}  // namespace equaltime
