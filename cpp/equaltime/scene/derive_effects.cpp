#include "equaltime/scene/derive_effects.h"

#include <algorithm>
#include <variant>

#include "equaltime/base/effects.h"
namespace equaltime {

namespace {

/// Adds the effects of a material and its parts.
void add_material(Effects& e, const Scene& scene, std::uint32_t index) noexcept {
  const Material& material = scene.appearance.materials[index];
  e.textures = e.textures || !material.bindings.empty() || material.normal_map;
  e.normal_maps = e.normal_maps || material.normal_map;
  if (material.kind != Material::Kind::leaf) {
    e.masks = true;
    if (material.kind == Material::Kind::mixture)
      for (const std::uint32_t part : material.parts) add_material(e, scene, part);
    return;
  }
  const Bsdf& bsdf = material.bsdf;
  e.anisotropy = e.anisotropy || material.anisotropic;
  if (!scene.rules.count_null_interfaces && std::holds_alternative<ThinDielectric<float>>(bsdf)) e.masks = true;
  visit<kAllEffects>(bsdf, [&]<class Model>(const Model&) noexcept {
    if constexpr (requires { Model::needs; }) e.*Model::needs = true;
  });
}

}  // namespace

Effects derive_effects(const Scene& scene) noexcept {
  const SceneGeometry& geometry = scene.geometry;
  const Volumes& volumes = scene.volumes;
  Effects e;
  AnalyticShapes::for_each([&]<class Shape>(std::type_identity<Shape>) {
    if (!geometry.analytic_shapes[AnalyticShapes::place_of<Shape>].empty()) e.*Shape::needs = true;
  });
  e.point_lights = scene.lights.has_deltas();
  e.environment = scene.lights.environment().has_value();
  e.instances = !geometry.instances.empty();
  const bool nests = !volumes.nesting.dielectrics.empty();
  e.media = !volumes.media.empty() || nests;
  for (const PhaseFunction& phase : volumes.phases)
    visit<kAllEffects>(phase, [&]<class Model>(const Model&) { e.*Model::needs = true; });
  e.specular = nests;  // rough surfaces between equal indices are replaced by smooth ones
  e.motion = geometry.moves() || scene.camera.motion;
  e.hidden_emitters = scene.rules.hides_emitters && scene.lights.size() > 0;
  e.lens = !std::holds_alternative<PerspectiveCamera>(scene.camera.sensor);
  e.textures = scene.lights.any_projects();
  for (const Surface& surface : geometry.surfaces) {
    e.smooth_normals = e.smooth_normals || !surface.mesh.normals.empty();
    e.textures = e.textures || surface.emission.texture != kNone;
    for (const std::uint32_t side : surface.material)
      if (side != kNone) add_material(e, scene, side);
  }
  return e;
}

}  // namespace equaltime
