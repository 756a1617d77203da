// Scene: everything that paths need, compiled from a SceneDescription, in normalised space (math/normalization.h).
// Any number of threads may read it. Nothing changes once it is built, but that Lights makes its tree and an
// environment its table when first asked.
#pragma once

#include <optional>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/math/normalization.h"
#include "equaltime/media/medium.h"
#include "equaltime/media/phase_function.h"
#include "equaltime/scene/lights.h"
#include "equaltime/scene/material.h"
#include "equaltime/scene/nesting.h"
#include "equaltime/scene/scene_geometry.h"
#include "equaltime/sensors/pixel_filter.h"
#include "equaltime/sensors/sensor.h"

namespace equaltime {

/// Materials, and the tables and textures that they read.
struct Appearance {
  BsdfTables tables;
  std::vector<Material> materials;  // one per BSDF of the description
  std::vector<Texture> textures;
  bool lets_light_pass = false;  // shadow rays may pass straight through some surface
};

/// Participating media, and dielectrics that overlap.
struct Volumes {
  std::vector<Medium> media;          // those with extinction
  std::vector<PhaseFunction> phases;  // one per medium
  Nesting nesting;
};

/// The sensor that makes rays, with its motion, pixel filter and film.
struct Camera {
  Sensor sensor;
  std::optional<CameraMotion> motion;
  PixelFilter filter;
  FilmDescription film;
};

/// Rules of the description for the counting of path vertices and for visible emitters; see SceneDescription.
struct PathRules {
  bool count_null_interfaces = true;
  bool hides_emitters = false;
};

struct Scene {
  SceneGeometry geometry;       // surfaces: which one a ray meets, and where exactly
  Appearance appearance;        // materials and textures
  Volumes volumes;              // media and nested dielectrics
  Lights lights;                // all of them, and how one is picked and sampled
  Camera camera;                // sensor, pixel filter and film
  PathRules rules;              // how null surfaces count, and whether emitters are visible
  Normalization normalization;  // units of the description

  /// Component of a material at a point, chosen by u: a leaf, or a null material.
  [[nodiscard]] std::uint32_t choose_component(std::uint32_t material, const Interaction& it, double u) const noexcept;
  /// Tilts the shading frame of a point by the normal or bump map of its leaf, if it has one.
  template <Effects E>
  EQUALTIME_INLINE void tilt_frame(std::uint32_t leaf, Interaction& it, float time) const noexcept {
    if constexpr (E.normal_maps)
      if (const auto& map = appearance.materials[leaf].normal_map) apply_normal_map(*map, it, E.motion ? time : 0);
  }
  /// BSDF of a leaf at a point. `made` stores a BSDF made by textures.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE const Bsdf& bsdf(std::uint32_t leaf, const Interaction& it,
                                                  std::optional<Bsdf>& made) const noexcept {
    const Material& material = appearance.materials[leaf];
    if constexpr (E.textures)
      if (!material.bindings.empty()) return material.at(appearance.textures, geometry.texture_coords(it), made);
    return material.bsdf;
  }
  /// Applies a normal or bump map to the shading frame of the interaction.
  void apply_normal_map(const NormalMap& map, Interaction& it, float time) const noexcept;
  /// Radiance that the front of an emissive surface sends back along the ray.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Spectrum radiance(const Interaction& it) const noexcept {
    const Surface& surface = geometry.surfaces[it.shape];
    if constexpr (E.textures)
      if (surface.emission.texture != kNone)
        return surface.emission.radiance *
               eval(appearance.textures[surface.emission.texture], geometry.texture_coords(it));
    return surface.emission.radiance;
  }
  /// Radiance of a light sample at a time, times the emitter's or projector's texture if there is one.
  [[nodiscard]] Spectrum radiance_of(const LightSample<float>& sample, float time) const noexcept;
  /// Radiance of a light sample of a scene in which nothing moves.
  [[nodiscard]] Spectrum radiance_of(const LightSample<float>& sample) const noexcept;
  /// Radiance of a light sample, times the texture that a spot light projects if it has one.
  [[nodiscard]] Spectrum projected(const LightSample<float>& sample) const noexcept;
  /// The emitter of a light sample if its emission has a texture; null otherwise.
  [[nodiscard]] const Emitter* textured_emitter(const LightSample<float>& sample) const noexcept;
  /// The dielectrics and the medium that hold the camera at a time.
  [[nodiscard]] CameraMedium camera_medium(float time) const noexcept;
  /// Bytes held for geometry, its acceleration structure, lights and textures.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

}  // namespace equaltime
