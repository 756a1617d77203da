#include "scene/emission.h"

#include <string>

#include "scene/build_meshes.h"
#include "scene/scene.h"

namespace equaltime {

namespace {

constexpr int kTriangleSteps = 6, kSquareSteps = 64;
constexpr float kLeast = 1e-3F;

/// Where the texture of an area light is looked up for a point of it.
TexturePlace place_of(const Scene& scene, const Emitter& emitter, const Vec3d& p) noexcept {
  const auto [shape, primitive] = emitter;
  const Surface& surface = scene.surfaces[shape];
  const Geometries& all = scene.accel.geometries();
  if (surface.kind == SurfaceKind::sphere)
    return {detail::sphere_uv(surface, Vec3f(normalize(p - all.spheres[primitive].center)))};
  if (surface.kind == SurfaceKind::disk) return {detail::disk_uv(all.disks[primitive], p)};
  if (surface.kind == SurfaceKind::cylinder) {
    const CylinderGeometry& tube = all.cylinders[primitive];
    const double height = dot(p - tube.base, tube.axis);
    return {detail::cylinder_uv(surface, Vec3f(normalize(p - tube.base - tube.axis * height)), height / tube.length)};
  }
  const MeshView& mesh = scene.meshes[surface.mesh];
  const auto& [a, b, c] = mesh.triangles[primitive];
  if (surface.light_per_primitive) {
    const auto [u, v] = barycentric(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], p);
    return scene.place(shape, primitive, {u, v});
  }
  // A rectangle, whose first triangle has its first edge from corner to corner and its second along the diagonal.
  const Vec3d corner(mesh.vertices[a]), x = Vec3d(mesh.vertices[b]) - corner, y = Vec3d(mesh.vertices[c]) - corner - x;
  const Vec3d r = p - corner;
  return {{static_cast<float>(dot(r, x) / length_squared(x)), static_cast<float>(dot(r, y) / length_squared(y))}};
}

/// The mean of a texture over a triangle, roughly, and no less than a little: what shines at all must have a chance to
/// be picked.
Spectrum mean_over_triangle(const Texture& texture, const Surface& surface, std::uint32_t shape,
                            std::uint32_t primitive, const Triangle& triangle) noexcept {
  const Point2f* uvs = surface.uvs.empty() ? nullptr : surface.uvs.data();
  Spectrum sum;
  constexpr float kStep = 1.0F / kTriangleSteps;
  for (int i = 0; i < kTriangleSteps; ++i)
    for (int j = 0; j < kTriangleSteps; ++j) {
      float u = (static_cast<float>(i) + 0.5F) * kStep, v = (static_cast<float>(j) + 0.5F) * kStep;
      if (u + v > 1) u = 1 - u, v = 1 - v;
      sum += eval(texture, on_triangle({u, v}, shape, primitive, triangle, uvs));
    }
  return sum * (kStep * kStep) + Spectrum(kLeast);
}

/// The same over the unit square.
Spectrum mean_over_square(const Texture& texture) noexcept {
  Spectrum sum;
  constexpr float kStep = 1.0F / kSquareSteps;
  for (int i = 0; i < kSquareSteps; ++i)
    for (int j = 0; j < kSquareSteps; ++j)
      sum += eval(texture, {{(static_cast<float>(i) + 0.5F) * kStep, (static_cast<float>(j) + 0.5F) * kStep}});
  return sum * (kStep * kStep) + Spectrum(kLeast);
}

}  // namespace

void AreaLights::set_emission(Surface& surface, std::size_t shape, std::uint32_t texture) const {
  if (texture >= textures.size()) fail(shape, "no texture " + std::to_string(texture) + " to shine by");
  if (const auto color = constant(textures[texture])) {
    surface.radiance *= *color;
  } else {
    surface.emission = texture;
    surface.textured = true;
  }
}

Spectrum AreaLights::mean_radiance(const Surface& surface) const noexcept {
  if (surface.emission == kNone) return surface.radiance;
  return surface.radiance * mean_over_square(textures[surface.emission]);
}

void AreaLights::add(Surface& surface, std::size_t shape, std::size_t primitive, const AreaLight& light) {
  if (surface.first_light == kNone) surface.first_light = static_cast<std::uint32_t>(lights.size());
  lights.push_back(light);
  emitters.push_back({static_cast<std::uint32_t>(shape), static_cast<std::uint32_t>(primitive)});
}

void AreaLights::add_rectangle(Surface& surface, std::size_t shape, const Vec3f& corner, const Vec3d& edge_x,
                               const Vec3d& edge_y, bool flipped) {
  const auto lit_by = [&](const Spectrum& mean) { return RectangleLight(corner, edge_x, edge_y, flipped, mean); };
  if (surface.emission == kNone || std::holds_alternative<MeshAttribute>(textures[surface.emission]))
    return add(surface, shape, 0, lit_by(mean_radiance(surface)));
  const auto picture = std::make_shared<const Picture>(textures[surface.emission], surface.radiance);
  add(surface, shape, 0, PictureLight(lit_by(Spectrum(static_cast<float>(picture->mean()))), picture));
}

void AreaLights::add_triangles(std::size_t shape, const TriangleMesh& mesh, Surface& surface, bool flipped) {
  if (surface.radiance.is_black()) return;
  surface.light_per_primitive = true;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Vec3f &v0 = mesh.vertices[a], &v1 = mesh.vertices[b], &v2 = mesh.vertices[c];
    Spectrum radiance = surface.radiance;
    if (surface.emission != kNone)
      radiance *= mean_over_triangle(textures[surface.emission], surface, static_cast<std::uint32_t>(shape),
                                     static_cast<std::uint32_t>(i), mesh.triangles[i]);
    add(surface, shape, i, TriangleLight(v0, flipped ? v2 : v1, flipped ? v1 : v2, radiance));
  }
}

Spectrum Scene::radiance_of(const LightSample& sample) const noexcept {
  if (emitters.empty() || sample.infinite || sample.delta) return sample.radiance;
  const Emitter& emitter = emitters[sample.light];
  const Surface& surface = surfaces[emitter.shape];
  if (surface.emission == kNone) return sample.radiance;
  return surface.radiance * eval(textures[surface.emission], place_of(*this, emitter, Vec3d(sample.target.p)));
}

}  // namespace equaltime
