// Effects: what a scene calls for. Derived from the scene, never asked for; a kernel is compiled for a set of effects
// and holds no code for the others. A structural type, so that a set is a template argument with named fields.
#pragma once

namespace equaltime {

struct Effects {
  bool analytic_shapes = false;   // spheres, disks and cylinders
  bool smooth_normals = false;    // interpolated over meshes
  bool rough_conductors = false;  // microfacets
  bool anisotropy = false;        // of microfacets: shading frames need tangents
  bool specular = false;          // smooth conductors and dielectrics: directions of a discrete set
  bool layered = false;           // plastics, and rough diffuse surfaces
  bool rough_dielectrics = false;
  bool principled = false;
  bool point_lights = false;  // and spots and directional lights: what no ray meets
  bool environment = false;
  bool lens = false;             // the camera is no pinhole: a thin lens, or parallel rays
  bool textures = false;         // parameters of BSDFs, and radiance, that vary over a surface
  bool normal_maps = false;      // and bump maps
  bool instances = false;        // groups of shapes that are seen more than once
  bool masks = false;            // surfaces of several BSDFs or of none, or that are crossed for nothing
  bool media = false;            // what is between surfaces takes or scatters light, or bodies overlap by priority
  bool phase_blends = false;     // media scatter by Rayleigh's law, or by several
  bool splitting = false;        // paths are split: no scene calls for it, but a strategy
  bool motion = false;           // something is elsewhere when the shutter closes than when it opens
  bool hidden_emitters = false;  // the camera does not see what shines

  constexpr bool operator==(const Effects&) const noexcept = default;

  /// A kernel for these effects renders every scene that calls for no others.
  [[nodiscard]] constexpr bool covers(const Effects& need) const noexcept;
};

struct EffectField {
  bool Effects::*value;
  const char* name;
};

/// Every effect by its name: what is done for each of them alike.
inline constexpr EffectField kEffectFields[] = {
    {&Effects::analytic_shapes, "analytic_shapes"},
    {&Effects::smooth_normals, "smooth_normals"},
    {&Effects::rough_conductors, "rough_conductors"},
    {&Effects::anisotropy, "anisotropy"},
    {&Effects::specular, "specular"},
    {&Effects::layered, "layered"},
    {&Effects::rough_dielectrics, "rough_dielectrics"},
    {&Effects::principled, "principled"},
    {&Effects::point_lights, "point_lights"},
    {&Effects::environment, "environment"},
    {&Effects::lens, "lens"},
    {&Effects::textures, "textures"},
    {&Effects::normal_maps, "normal_maps"},
    {&Effects::instances, "instances"},
    {&Effects::masks, "masks"},
    {&Effects::media, "media"},
    {&Effects::phase_blends, "phase_blends"},
    {&Effects::splitting, "splitting"},
    {&Effects::motion, "motion"},
    {&Effects::hidden_emitters, "hidden_emitters"},
};
static_assert(sizeof(kEffectFields) / sizeof(EffectField) == sizeof(Effects), "an effect has no name");

constexpr bool Effects::covers(const Effects& need) const noexcept {
  for (const auto& [value, name] : kEffectFields)
    if (need.*value && !(this->*value)) return false;
  return true;
}

inline constexpr Effects kAllEffects = [] {
  Effects all;
  for (const auto& [value, name] : kEffectFields) all.*value = true;
  return all;
}();

}  // namespace equaltime
