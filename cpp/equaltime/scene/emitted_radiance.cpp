// Radiance of sampled points of lights that emit by a texture.
#include "equaltime/scene/scene.h"
#include "equaltime/scene/surface.h"

namespace equaltime {

namespace {

/// Texture coordinates of a point of an area light, in the local space of its shape range.
TextureCoords place_of(const SceneGeometry& geometry, const Geometries& all, const Emitter& emitter,
                       const Vec3d& p) noexcept {
  const auto [shape, primitive] = emitter;
  const Surface& surface = geometry.surfaces[shape];
  if (surface.mesh.number == kNone)
    return AnalyticShapes::at(surface.analytic.kind,
                              [&, i = primitive]<class Shape>(std::type_identity<Shape>) noexcept {
                                const Shape& light = all.of<Shape>()[i];
                                return TextureCoords{detail::uv_at(light, surface.analytic, hit_at(light, p))};
                              });
  const MeshView& mesh = geometry.meshes[surface.mesh.number];
  const auto& [a, b, c] = mesh.triangles[primitive];
  if (surface.emission.light_per_primitive) {
    const auto [u, v] = barycentric(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], p);
    return geometry.texture_coords(shape, primitive, {u, v});
  }
  // A rectangle, whose first triangle has its first edge from corner to corner and its second along the diagonal.
  const Vec3d corner(mesh.vertices[a]), x = Vec3d(mesh.vertices[b]) - corner, y = Vec3d(mesh.vertices[c]) - corner - x;
  const Vec3d r = p - corner;
  return {{static_cast<float>(dot(r, x) / length_squared(x)), static_cast<float>(dot(r, y) / length_squared(y))}};
}

}  // namespace

const Emitter* Scene::textured_emitter(const LightSample<float>& sample) const noexcept {
  if (geometry.emitters.empty() || sample.infinite || sample.delta) return nullptr;
  const Emitter& emitter = geometry.emitters[sample.light];
  return geometry.surfaces[emitter.shape].emission.texture == kNone ? nullptr : &emitter;
}

Spectrum Scene::projected(const LightSample<float>& sample) const noexcept {
  const SpotLight* spot = lights.projector(sample);
  if (spot == nullptr) return sample.radiance;
  return sample.radiance * eval(appearance.textures[spot->slide()->texture], spot->place_on_slide(sample.wi));
}

Spectrum Scene::radiance_of(const LightSample<float>& sample) const noexcept {
  const Emitter* emitter = textured_emitter(sample);
  if (emitter == nullptr) return projected(sample);
  const Surface& surface = geometry.surfaces[emitter->shape];
  const TextureCoords place = place_of(geometry, geometry.accel.geometries(), *emitter, Vec3d(sample.target.p));
  return surface.emission.radiance * eval(appearance.textures[surface.emission.texture], place);
}

Spectrum Scene::radiance_of(const LightSample<float>& sample, float time) const noexcept {
  const Emitter* emitter = textured_emitter(sample);
  const MovingInstanceGeometry* carrier = emitter == nullptr ? nullptr : lights.moving_instance(sample.light);
  if (carrier == nullptr) return radiance_of(sample);
  const Surface& surface = geometry.surfaces[emitter->shape];
  const Vec3d local = carrier->to_world.at(static_cast<double>(time)).local_point(Vec3d(sample.target.p));
  const TextureCoords place = place_of(geometry, geometry.accel.groups()[carrier->group], *emitter, local);
  return surface.emission.radiance * eval(appearance.textures[surface.emission.texture], place);
}

}  // namespace equaltime
