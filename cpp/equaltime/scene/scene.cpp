#include "equaltime/scene/scene.h"

#include "equaltime/scene/held_bytes.h"

namespace equaltime {

CameraMedium Scene::camera_medium(float time) const noexcept {
  CameraMedium now = volumes.nesting.fixed;
  const Vec3d position = camera.motion ? camera.motion->place(time) : volumes.nesting.camera;
  for (const ClosedShape& closed : volumes.nesting.time_dependent) {
    std::optional<Instance> in;
    if (closed.instance != kNone) in = geometry.instance_at(closed.instance, time);
    closed.include_if_inside(now, geometry.surfaces[closed.shape], position, in ? &*in : nullptr, time);
  }
  return now;
}

std::uint32_t Scene::choose_component(std::uint32_t index, const Interaction& it, double u) const noexcept {
  const std::vector<Material>& materials = appearance.materials;
  while (materials[index].kind == Material::Kind::mixture) {
    const double w = materials[index].weight_at(appearance.textures, geometry.texture_coords(it));
    const bool second = u < w;
    u = std::min(second ? u / w : (u - w) / (1 - w), 1 - 0x1p-53);
    index = materials[index].parts[second ? 1 : 0];
  }
  return index;
}

std::size_t Scene::memory_bytes() const noexcept {
  const auto& [tables, materials, textures, passes] = appearance;
  std::size_t bytes = geometry.memory_bytes() + lights.memory_bytes() + volumes.nesting.memory_bytes();
  bytes += held(volumes.media) + held(materials) + held(textures) + tables.memory_bytes();
  for (const Material& material : materials) bytes += held(material.bindings);
  for (const Texture& texture : textures) bytes += std::visit([](const auto& t) { return t.memory_bytes(); }, texture);
  return bytes;
}

}  // namespace equaltime
