// SceneGeometry: all that rays meet, and how a hit becomes an interaction. Points are computed anew in float64.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "equaltime/accel/accel.h"
#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/scene/deforming_mesh.h"
#include "equaltime/scene/emitter.h"
#include "equaltime/scene/instance.h"
#include "equaltime/scene/recompute_hit.h"
#include "equaltime/scene/surface.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

/// Derivatives of a surface point by its texture coordinates.
struct Derivatives {
  Vec3f du, dv;
};

/// The default guard of ray queries: does nothing.
struct Unguarded {};

struct SceneGeometry {
  Accel accel;
  /// One per shape, in the order of the description. The shapes of groups come after all others.
  std::vector<Surface> surfaces;
  /// Primitives of the scene itself, and of each group. A rectangle is a mesh of two triangles.
  ShapeRange top;
  std::vector<ShapeRange> groups;
  /// Moving instances are numbered after the static ones.
  std::vector<Instance> instances;
  std::vector<MovingInstanceGeometry> moving;
  std::vector<MeshView> meshes;
  std::vector<std::optional<DeformingMesh>> deforming;  // one per mesh; empty if none deforms
  /// Shape of each analytic primitive, by kind.
  std::array<std::vector<std::uint32_t>, AnalyticShapes::size> analytic_shapes;
  /// Shape and primitive of each area light. Empty if no texture emits and no dielectrics overlap.
  std::vector<Emitter> emitters;
  std::size_t dropped_triangles = 0;  // of area 0: no ray can meet them

  /// The nearest surface that the ray meets, at a time from 0 to 1 if anything moves. E prunes kinds of shapes that the
  /// scene cannot hold. A Guard lives while Embree searches.
  template <Effects E, class Guard = Unguarded>
  [[nodiscard]] SurfaceIntersection<E> closest(const Ray& ray, float time) const noexcept;
  /// The interaction at a hit of an instance.
  template <Effects E>
  [[nodiscard, gnu::noinline]] SurfaceIntersection<E> in_instance(const Hit& hit, const Ray& ray,
                                                                  float time) const noexcept;
  /// Whether any surface stands in the way of the ray.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE bool occluded(const Ray& ray, float time) const noexcept {
    return accel.occluded<E>(ray, time);
  }
  /// Recomputes a hit point in float64. `ray` is in the local space of the shape range. `geometries()` gives the
  /// range's geometries, and is called only where they are needed, since the call is not free.
  template <Effects E, class GeometriesOf>
  [[nodiscard]] detail::SurfacePoint recompute_hit(const ShapeRange& set, GeometriesOf&& geometries,
                                                   const PrimitiveId& id, const RayD& ray, float time) const noexcept;

  /// Whether anything that rays meet moves or deforms.
  [[nodiscard]] bool moves() const noexcept { return accel.moves(); }
  /// The instance with this number, at a time if it moves.
  [[nodiscard]] Instance instance_at(std::uint32_t number, float time) const noexcept {
    if (number < instances.size()) return instances[number];
    const auto& [group, to_world] = moving[number - instances.size()];
    return {group, to_world.at(static_cast<double>(time))};
  }
  /// The corners of a triangle of a mesh, in the mesh's own space.
  [[nodiscard]] std::array<Vec3f, 3> corners(std::uint32_t mesh, std::uint32_t primitive, float time) const noexcept;
  [[nodiscard]] Derivatives derivatives(const Interaction& it, float time) const noexcept;
  /// Texture coordinates of a point of a textured surface. A mesh without any uses the barycentric coordinates of its
  /// triangles.
  [[nodiscard]] TextureCoords texture_coords(const Interaction& it) const noexcept {
    return texture_coords(it.shape, it.primitive, it.prim_uv);
  }
  [[nodiscard]] TextureCoords texture_coords(std::uint32_t shape, std::uint32_t primitive,
                                             Point2f on_primitive) const noexcept;
  /// Index of the material on the side that the interaction is on; kNone if that side absorbs.
  [[nodiscard]] std::uint32_t material(const Interaction& it) const noexcept {
    return surfaces[it.shape].material[it.front ? 0 : 1];
  }
  [[nodiscard]] bool emits(const Interaction& it) const noexcept {
    return surfaces[it.shape].emission.first_light != kNone;
  }
  /// Number in Scene::lights of the emissive primitive that the interaction is on.
  [[nodiscard]] std::uint32_t light_of(const Interaction& it) const noexcept {
    const Surface& surface = surfaces[it.shape];
    return surface.emission.first_light + (surface.emission.light_per_primitive ? it.primitive : 0);
  }
  [[nodiscard]] std::size_t triangle_count() const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

template <Effects E, class Guard>
EQUALTIME_INLINE SurfaceIntersection<E> SceneGeometry::closest(const Ray& ray, float time) const noexcept {
  Optional<Hit> hit = [&]() noexcept {
    [[maybe_unused]] const Guard guard;
    return accel.closest<E>(ray, time);
  }();
  if (!hit) return {};
  if constexpr (E.instances || E.motion)
    if (hit->instance != kNotInstanced) return in_instance<E>(*hit, ray, time);
  const auto own = [this]() noexcept -> const Geometries& { return accel.geometries(); };
  return detail::make_intersection<E>(recompute_hit<E>(top, own, hit->id, RayD(ray), time), ray);
}

template <Effects E>
SurfaceIntersection<E> SceneGeometry::in_instance(const Hit& hit, const Ray& ray, float time) const noexcept {
  const Instance instance = instance_at(hit.instance, time);
  const std::uint32_t group = instance.group();
  const auto grouped = [&]() noexcept -> const Geometries& { return accel.groups()[group]; };
  const detail::SurfacePoint point =
      instance.placed(recompute_hit<E>(groups[group], grouped, hit.id, instance.to_local(RayD(ray)), time));
  SurfaceIntersection<E> intersection = detail::make_intersection<E>(point, ray);
  intersection.it->instance = hit.instance;
  return intersection;
}

template <Effects E, class GeometriesOf>
EQUALTIME_INLINE detail::SurfacePoint SceneGeometry::recompute_hit(const ShapeRange& set, GeometriesOf&& geometries,
                                                                   const PrimitiveId& id, const RayD& ray,
                                                                   [[maybe_unused]] float time) const noexcept {
  if constexpr (E.analytic_shapes)
    if (id.geometry >= set.mesh_count)
      return AnalyticShapes::at(
          id.geometry - set.mesh_count, [&]<class Shape>(std::type_identity<Shape>) __attribute__((always_inline)) {
            constexpr std::size_t kKind = AnalyticShapes::place_of<Shape>;
            const std::uint32_t shape = analytic_shapes[kKind][set.first[kKind] + id.primitive];
            return detail::recompute_hit<E>(geometries().template of<Shape>()[id.primitive], surfaces[shape], ray,
                                            shape);
          });
  std::uint32_t mesh = id.geometry;
  if constexpr (E.instances || E.motion) mesh += set.first_mesh;
  if constexpr (E.motion)
    if (!deforming.empty() && deforming[mesh])
      return recompute_deforming_hit<E>(*deforming[mesh], meshes[mesh], ray, id.primitive, time);
  return detail::recompute_hit<E>(meshes[mesh], ray, id.primitive);
}

}  // namespace equaltime
