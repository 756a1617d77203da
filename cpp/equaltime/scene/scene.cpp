#include "equaltime/scene/scene.h"

#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// The azimuth of (x, y), in turns from 0 to 1.
double azimuth(double x, double y) noexcept {
  const double turns = elementary::atan2(y, x) * (0.5 * std::numbers::inv_pi);
  return turns < 0 ? turns + 1 : turns;
}

}  // namespace

TextureCoords Scene::place(std::uint32_t shape, std::uint32_t primitive, Point2f on_primitive) const noexcept {
  const std::uint32_t mesh = surfaces[shape].mesh;
  if (mesh == kNone) return {on_primitive, shape, primitive};
  return on_triangle(on_primitive, shape, primitive, meshes[mesh].triangles[primitive], meshes[mesh].uvs);
}

std::array<Vec3f, 3> Scene::corners(std::uint32_t mesh, std::uint32_t primitive, float time) const noexcept {
  if (!deforming.empty() && deforming[mesh]) return deforming[mesh]->corners(primitive, time);
  const auto& [a, b, c] = meshes[mesh].triangles[primitive];
  const Vec3f* vertices = meshes[mesh].vertices;
  return {vertices[a], vertices[b], vertices[c]};
}

CameraMedium Scene::beginning(float time) const noexcept {
  CameraMedium now = nesting.always;
  const Vec3d camera = camera_motion ? camera_motion->place(time) : nesting.camera;
  for (const ClosedShape& closed : nesting.sometimes) {
    std::optional<Instance> in;
    if (closed.instance != kNone) in = instance_at(closed.instance, time);
    closed.look(now, surfaces[closed.shape], camera, in ? &*in : nullptr, time);
  }
  return now;
}

std::uint32_t Scene::choose_component(std::uint32_t index, const Interaction& it, double u) const noexcept {
  while (materials[index].kind == Material::Kind::mixture) {
    const double w = materials[index].weight_at(textures, place(it));
    const bool second = u < w;
    u = std::min(second ? u / w : (u - w) / (1 - w), 1 - 0x1p-53);
    index = materials[index].parts[second ? 1 : 0];
  }
  return index;
}

std::size_t Scene::triangle_count() const noexcept {
  std::size_t n = 0;
  for (const Surface& surface : surfaces) n += surface.planes.size();
  return n;
}

namespace {

template <class T>
std::size_t held(const std::vector<T>& list) noexcept {
  return list.capacity() * sizeof(T);
}

std::size_t held_by(const Geometries& all) noexcept {
  std::size_t bytes = held(all.meshes) + held(all.spheres) + held(all.disks) + held(all.cylinders);
  for (const TriangleMesh& mesh : all.meshes) {
    bytes += held(mesh.vertices) + held(mesh.triangles) + held(mesh.later);
    for (const std::vector<Vec3f>& later : mesh.later) bytes += held(later);
  }
  return bytes;
}

std::size_t held_by(const Surface& surface) noexcept {
  std::size_t bytes = held(surface.planes) + held(surface.normals) + held(surface.tangents) + held(surface.uvs) +
                      held(surface.later_normals);
  for (const std::vector<Vec3f>& later : surface.later_normals) bytes += held(later);
  return bytes;
}

}  // namespace

std::size_t Scene::memory_bytes() const noexcept {
  std::size_t bytes = accel.memory_bytes() + lights.memory_bytes() + nesting.memory_bytes();
  bytes += held_by(accel.geometries()) + held(accel.groups());
  for (const Geometries& group : accel.groups()) bytes += held_by(group);
  bytes += held(surfaces) + held(groups) + held(instances) + held(moving) + held(deforming) + held(meshes) +
           held(sphere_shapes) + held(disk_shapes) + held(cylinder_shapes) + held(emitters) + held(media) +
           held(materials) + held(textures) + bsdf_tables.memory_bytes();
  for (const MovingInstanceGeometry& instance : moving) bytes += instance.to_world.memory_bytes();
  for (const Surface& surface : surfaces) bytes += held_by(surface);
  for (const Material& material : materials) bytes += held(material.bindings);
  for (const Texture& texture : textures) bytes += std::visit([](const auto& t) { return t.memory_bytes(); }, texture);
  return bytes;
}

namespace detail {

Point2f sphere_uv(const Surface& surface, const Vec3f& n) noexcept {
  const auto x = static_cast<double>(dot(surface.azimuth[0], n)), y = static_cast<double>(dot(surface.azimuth[1], n));
  const double polar = elementary::atan2(elementary::hypot(x, y), static_cast<double>(dot(surface.pole, n)));
  return {static_cast<float>(azimuth(x, y)), static_cast<float>(polar * std::numbers::inv_pi)};
}

Point2f cylinder_uv(const Surface& surface, const Vec3f& n, double height) noexcept {
  const auto x = static_cast<double>(dot(surface.azimuth[0], n)), y = static_cast<double>(dot(surface.azimuth[1], n));
  return {static_cast<float>(azimuth(x, y)), static_cast<float>(height)};
}

Point2f disk_uv(const DiskGeometry& disk, const Vec3d& point) noexcept {
  const Vec3d r = point - disk.center;
  const double x = dot(disk.inv_u, r), y = dot(disk.inv_v, r);
  return {static_cast<float>(elementary::hypot(x, y)), static_cast<float>(azimuth(x, y))};
}

}  // namespace detail

}  // namespace equaltime
