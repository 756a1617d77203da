// Effects: what a scene calls for. Derived from the scene, never asked for; a kernel is compiled for a set of effects
// and holds no code for the others. A structural type, so that a set is a template argument with named fields.
#pragma once

#include "scene/scene.h"

namespace equaltime {

struct Effects {
  bool analytic_shapes = false;   // spheres, disks and cylinders
  bool smooth_normals = false;    // interpolated over meshes
  bool rough_conductors = false;  // microfacets
  bool anisotropy = false;        // of microfacets: shading frames need tangents
  bool specular = false;          // smooth conductors and dielectrics: directions of a discrete set
  bool layered = false;           // plastics: an interface over a diffuse body
  bool point_lights = false;      // and spots and directional lights: what no ray meets
  bool environment = false;
  bool lens = false;  // the camera is no pinhole: a thin lens, or parallel rays

  constexpr bool operator==(const Effects&) const noexcept = default;

  /// A kernel for these effects renders every scene that calls for no others.
  [[nodiscard]] constexpr bool covers(const Effects& need) const noexcept {
    return (analytic_shapes || !need.analytic_shapes) && (smooth_normals || !need.smooth_normals) &&
           (rough_conductors || !need.rough_conductors) && (anisotropy || !need.anisotropy) &&
           (specular || !need.specular) && (layered || !need.layered) && (point_lights || !need.point_lights) &&
           (environment || !need.environment) && (lens || !need.lens);
  }
};

inline constexpr Effects kAllEffects{true, true, true, true, true, true, true, true, true};

[[nodiscard]] Effects derive_effects(const Scene& scene) noexcept;

}  // namespace equaltime
