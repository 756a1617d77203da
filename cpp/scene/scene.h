// Scene: everything a path meets, compiled from a SceneDescription, in normalised space (scene/normalization.h).
// Immutable; any number of threads may read it.
#pragma once

#include <string>
#include <vector>

#include "accel/accel.h"
#include "math/optional.h"
#include "scene/bsdf.h"
#include "scene/interaction.h"
#include "scene/lights.h"
#include "scene/normalization.h"
#include "scene/pixel_filter.h"
#include "scene/sensor.h"
#include "scene/surface.h"

namespace equaltime {

/// All that shading needs of one of the accel's meshes, one step away: views into the scene's own arrays.
struct MeshView {
  const Triangle* triangles;
  const Vec3f* vertices;
  const TrianglePlane* planes;
  const Vec3f* normals;  // null: flat
  std::uint32_t shape;
  bool flipped;
};

struct Scene {
  Normalization normalization;
  Accel accel;
  std::vector<Surface> surfaces;  // one a shape, in the order of the description
  std::vector<MeshView> meshes;   // one a mesh of accel (rectangles are meshes of two triangles)
  std::vector<std::uint32_t> sphere_shapes;
  std::vector<std::uint32_t> disk_shapes;
  std::vector<Bsdf> bsdfs;
  Lights lights;
  PerspectiveCamera camera;
  PixelFilter filter;
  FilmDescription film;
  std::size_t dropped_triangles = 0;  // of no area, so that no ray can meet them

  /// The nearest surface that the ray meets. E prunes kinds of shapes that the scene cannot hold.
  template <auto E>
  [[nodiscard]] Optional<Interaction> intersect(const Ray& ray) const noexcept;

  /// BSDF on the side that the interaction is on; null where that side absorbs.
  [[nodiscard]] const Bsdf* bsdf(const Interaction& it) const noexcept {
    const std::uint32_t index = surfaces[it.shape].bsdf[it.front ? 0 : 1];
    return index == kNone ? nullptr : &bsdfs[index];
  }
  /// Index in `lights` of the emissive primitive that the interaction is on.
  [[nodiscard]] std::uint32_t light_of(const Interaction& it) const noexcept {
    const Surface& surface = surfaces[it.shape];
    return surface.first_light + (surface.light_per_primitive ? it.primitive : 0);
  }
  [[nodiscard]] std::size_t triangle_count() const noexcept;
  /// Bytes held for geometry, its acceleration structure, lights and textures.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// Throws std::invalid_argument that names the shape and what is wrong: a vertex that is not finite, an index out of
/// range.
[[nodiscard]] Scene build_scene(SceneDescription description, Intersection mode = Intersection::robust);

namespace detail {

/// An interaction turned to the side that the ray, whose direction is unit, came from.
[[nodiscard]] EQUALTIME_INLINE Interaction face(const SurfaceAnchor& anchor, const Vec3f& shading_normal,
                                                const Ray& ray, std::uint32_t shape, std::uint32_t primitive,
                                                bool flipped, bool smooth = false) noexcept {
  const float side = dot(ray.direction, anchor.n) > 0 ? -1.0F : 1.0F;
  const bool front = (side > 0) != flipped;
  return {{anchor.p, anchor.n * side, anchor.offset},
          Frame::from_normal(shading_normal * side),
          -ray.direction,
          shape,
          primitive,
          front};
}

[[nodiscard]] inline Interaction on_sphere(const SphereGeometry& sphere, const Ray& ray, std::uint32_t shape,
                                           bool flipped) noexcept {
  const double t = intersect_sphere(sphere, ray).value_or(0);
  const Vec3d n = normalize(Vec3d(ray.origin) + Vec3d(ray.direction) * t - sphere.center);
  const Vec3f nf(n), p(sphere.center + n * sphere.radius);
  return face({p, nf, point_offset(p, nf)}, nf, ray, shape, 0, flipped);
}

[[nodiscard]] inline Interaction on_disk(const DiskGeometry& disk, const Ray& ray, std::uint32_t shape,
                                         bool flipped) noexcept {
  const double t = intersect_disk(disk, ray).value_or(0);
  const Vec3f nf(disk.normal), p(Vec3d(ray.origin) + Vec3d(ray.direction) * t);
  return face({p, nf, point_offset(p, nf)}, nf, ray, shape, 0, flipped);
}

template <auto E>
[[nodiscard]] EQUALTIME_INLINE Interaction on_triangle(const MeshView& mesh, const Ray& ray,
                                                       std::uint32_t primitive) noexcept {
  const Triangle& t = mesh.triangles[primitive];
  const Vec3f &v0 = mesh.vertices[t[0]], &v1 = mesh.vertices[t[1]], &v2 = mesh.vertices[t[2]];
  const Vec3d p = triangle_point(v0, v1, v2, ray);
  const TrianglePlane& plane = mesh.planes[primitive];
  Vec3f ns = plane.n;
  const bool smooth = E.smooth_normals && mesh.normals != nullptr;
  if (smooth) {
    const auto [u, v] = barycentric(v0, v1, v2, p);
    const Vec3f sum = mesh.normals[t[0]] * (1 - u - v) + mesh.normals[t[1]] * u + mesh.normals[t[2]] * v;
    if (length_squared(sum) > 0) ns = normalize(sum);
  }
  return face({Vec3f(p), plane.n, plane.offset}, ns, ray, mesh.shape, primitive, mesh.flipped, smooth);
}

}  // namespace detail

template <auto E>
EQUALTIME_INLINE Optional<Interaction> Scene::intersect(const Ray& ray) const noexcept {
  const Optional<PrimitiveId> hit = accel.intersect(ray);
  if (!hit) return std::nullopt;
  if constexpr (E.analytic_shapes) {
    if (hit->geometry >= meshes.size()) {
      const bool sphere = hit->geometry == meshes.size();
      const std::uint32_t shape = sphere ? sphere_shapes[hit->primitive] : disk_shapes[hit->primitive];
      const bool flipped = surfaces[shape].flipped;
      if (sphere) return detail::on_sphere(accel.spheres()[hit->primitive], ray, shape, flipped);
      return detail::on_disk(accel.disks()[hit->primitive], ray, shape, flipped);
    }
  }
  return detail::on_triangle<E>(meshes[hit->geometry], ray, hit->primitive);
}

}  // namespace equaltime
