// Scene: everything a path meets, compiled from a SceneDescription, in normalised space (scene/normalization.h).
// Immutable; any number of threads may read it.
#pragma once

#include <string>
#include <vector>

#include "accel/accel.h"
#include "math/optional.h"
#include "scene/interaction.h"
#include "scene/lights.h"
#include "scene/material.h"
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
  const Vec3f* normals;   // null: flat
  const Vec3f* tangents;  // one a triangle; null: no BSDF looks at them
  const Point2f* uvs;     // null: none, or no texture looks at them
  bool textured;
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
  std::vector<std::uint32_t> cylinder_shapes;
  std::vector<Material> materials;  // one a BSDF of the description
  std::vector<Texture> textures;
  Lights lights;
  Sensor sensor;
  PixelFilter filter;
  FilmDescription film;
  std::size_t dropped_triangles = 0;  // of no area, so that no ray can meet them

  /// The nearest surface that the ray meets. E prunes kinds of shapes that the scene cannot hold.
  template <auto E>
  [[nodiscard]] Optional<Interaction> intersect(const Ray& ray) const noexcept;

  /// Material on the side that the interaction is on; kNone where that side absorbs.
  [[nodiscard]] std::uint32_t material(const Interaction& it) const noexcept {
    return surfaces[it.shape].bsdf[it.front ? 0 : 1];
  }
  /// The part of a material that is picked at the point: a leaf or nothing.
  [[nodiscard]] std::uint32_t picked(std::uint32_t material, const Interaction& it, float u) const noexcept;
  /// The share of light that passes straight through a material at the point.
  [[nodiscard]] float passing(std::uint32_t material, const Interaction& it) const noexcept;
  /// BSDF of a leaf at the point. One that textures make is put in `own`.
  template <auto E>
  [[nodiscard]] EQUALTIME_INLINE const Bsdf& bsdf(std::uint32_t leaf, const Interaction& it,
                                                  std::optional<Bsdf>& own) const noexcept {
    const Material& material = materials[leaf];
    if constexpr (E.textures)
      if (!material.bindings.empty()) return own.emplace(material.at(textures, uv(it)));
    return material.bsdf;
  }
  /// Texture coordinates of a point of a textured surface. A mesh that has none takes its triangles' barycentric ones.
  [[nodiscard]] Point2f uv(const Interaction& it) const noexcept;
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

/// A point met by a ray, before it is known from which side.
struct Met {
  SurfaceAnchor anchor;
  Vec3f shading_normal;
  Vec3f tangent;  // of any length; zero where none matters
  std::uint32_t shape, primitive;
  bool flipped, smooth;
  Point2f place;
};

/// The interaction on the side that the ray, whose direction is unit, came from.
template <auto E>
[[nodiscard]] EQUALTIME_INLINE Interaction face(const Met& met, const Ray& ray) noexcept {
  const float side = dot(ray.direction, met.anchor.n) > 0 ? -1.0F : 1.0F;
  const Vec3f ns = met.shading_normal * side;
  Frame frame;
  if constexpr (E.anisotropy)
    frame = Frame::from_tangent(ns, met.tangent);
  else
    frame = Frame::from_normal(ns);
  SurfaceAnchor anchor{met.anchor.p, met.anchor.n * side, met.anchor.offset};
  return {anchor, frame, -ray.direction, met.shape, met.primitive, (side > 0) != met.flipped, met.smooth, met.place};
}

/// Azimuth and polar angle, in whole turns and half turns.
[[nodiscard]] Point2f sphere_uv(const Surface& surface, const Vec3f& n) noexcept;
/// Azimuth, in turns, and height, from 0 at the base to 1.
[[nodiscard]] Point2f cylinder_uv(const Surface& surface, const Vec3f& n, double height) noexcept;
/// Distance from the centre, in radii, and azimuth, in turns.
[[nodiscard]] Point2f disk_uv(const DiskGeometry& disk, const Vec3d& point) noexcept;

template <auto E>
[[nodiscard]] Interaction on_sphere(const SphereGeometry& sphere, const Surface& surface, const Ray& ray,
                                    std::uint32_t shape) noexcept {
  const double t = intersect_sphere(sphere, ray).value_or(0);
  const Vec3d n = normalize(Vec3d(ray.origin) + Vec3d(ray.direction) * t - sphere.center);
  const Vec3f nf(n), p(sphere.center + n * sphere.radius);
  Met met{{p, nf, point_offset(p, nf)}, nf, cross(surface.pole, nf), shape, 0, surface.flipped, false, {}};
  if constexpr (E.textures)
    if (surface.textured) met.place = sphere_uv(surface, nf);
  return face<E>(met, ray);
}

template <auto E>
[[nodiscard]] Interaction on_disk(const DiskGeometry& disk, const Surface& surface, const Ray& ray,
                                  std::uint32_t shape) noexcept {
  const double t = intersect_disk(disk, ray).value_or(0);
  const Vec3d point = Vec3d(ray.origin) + Vec3d(ray.direction) * t;
  const Vec3f nf(disk.normal), p(point), radial(point - disk.center);
  Met met{{p, nf, point_offset(p, nf)}, nf, radial, shape, 0, surface.flipped, false, {}};
  if constexpr (E.textures)
    if (surface.textured) met.place = disk_uv(disk, point);
  return face<E>(met, ray);
}

template <auto E>
[[nodiscard]] Interaction on_cylinder(const CylinderGeometry& cylinder, const Surface& surface, const Ray& ray,
                                      std::uint32_t shape) noexcept {
  const double t = intersect_cylinder(cylinder, ray).value_or(0);
  const Vec3d r = Vec3d(ray.origin) + Vec3d(ray.direction) * t - cylinder.base;
  const double height = dot(r, cylinder.axis);
  const Vec3d n = normalize(r - cylinder.axis * height);
  const Vec3f nf(n), p(cylinder.base + cylinder.axis * height + n * cylinder.radius);
  const Vec3f around(cross(cylinder.axis, n));
  Met met{{p, nf, point_offset(p, nf)}, nf, around, shape, 0, surface.flipped, false, {}};
  if constexpr (E.textures)
    if (surface.textured) met.place = cylinder_uv(surface, nf, height / cylinder.length);
  return face<E>(met, ray);
}

template <auto E>
[[nodiscard]] EQUALTIME_INLINE Interaction on_triangle(const MeshView& mesh, const Ray& ray,
                                                       std::uint32_t primitive) noexcept {
  const TrianglePlane& plane = mesh.planes[primitive];
  Vec3d p = plane.meet(ray);
  Vec3f n(plane.n);
  const bool smooth = E.smooth_normals && mesh.normals != nullptr;
  const bool textured = E.textures && mesh.textured;
  Vec3f ns = n;
  Point2f place{};
  if (smooth || textured) {
    const Triangle& t = mesh.triangles[primitive];
    const Vec3f &v0 = mesh.vertices[t[0]], &v1 = mesh.vertices[t[1]], &v2 = mesh.vertices[t[2]];
    const auto [u, v] = barycentric(v0, v1, v2, p);
    if (smooth) {
      const Vec3f sum = mesh.normals[t[0]] * (1 - u - v) + mesh.normals[t[1]] * u + mesh.normals[t[2]] * v;
      if (length_squared(sum) > 0) ns = normalize(sum);
    }
    if (textured) place = {u, v};
  }
  Vec3f tangent;
  if constexpr (E.anisotropy)
    if (mesh.tangents != nullptr) tangent = mesh.tangents[primitive];
  return face<E>({{Vec3f(p), n, plane.offset}, ns, tangent, mesh.shape, primitive, mesh.flipped, smooth, place}, ray);
}

}  // namespace detail

template <auto E>
EQUALTIME_INLINE Optional<Interaction> Scene::intersect(const Ray& ray) const noexcept {
  Optional<PrimitiveId> hit = accel.intersect(ray);
  if (!hit) return std::nullopt;
  if constexpr (E.analytic_shapes) {
    if (hit->geometry >= meshes.size()) {
      const Geometries& all = accel.geometries();
      const std::uint32_t i = hit->primitive;
      switch (hit->geometry - meshes.size()) {
        case 0:
          return detail::on_sphere<E>(all.spheres[i], surfaces[sphere_shapes[i]], ray, sphere_shapes[i]);
        case 1:
          return detail::on_disk<E>(all.disks[i], surfaces[disk_shapes[i]], ray, disk_shapes[i]);
        default:
          return detail::on_cylinder<E>(all.cylinders[i], surfaces[cylinder_shapes[i]], ray, cylinder_shapes[i]);
      }
    }
  }
  return detail::on_triangle<E>(meshes[hit->geometry], ray, hit->primitive);
}

}  // namespace equaltime
