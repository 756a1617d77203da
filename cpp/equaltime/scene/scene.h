// Scene: everything a path meets, compiled from a SceneDescription, in normalised space (math/normalization.h).
// Immutable; any number of threads may read it.
#pragma once

#include <string>
#include <vector>

#include "equaltime/accel/accel.h"
#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/normalization.h"
#include "equaltime/media/medium.h"
#include "equaltime/media/phase_function.h"
#include "equaltime/scene/deforming_mesh.h"
#include "equaltime/scene/emitter.h"
#include "equaltime/scene/instance.h"
#include "equaltime/scene/lights.h"
#include "equaltime/scene/material.h"
#include "equaltime/scene/nesting.h"
#include "equaltime/scene/surface.h"
#include "equaltime/sensors/pixel_filter.h"
#include "equaltime/sensors/sensor.h"

namespace equaltime {

/// How a point moves with its texture coordinates.
struct Derivatives {
  Vec3f du, dv;
};

/// The default guard of ray queries: does nothing.
struct Unguarded {};

struct Scene {
  Normalization normalization;
  Accel accel;
  std::vector<Surface> surfaces;  // one a shape, in the order of the description; those of groups come after all others
  // Primitives, first what stands in the scene itself, then group by group (rectangles are meshes of two triangles).
  ShapeRange top;
  std::vector<ShapeRange> groups;
  std::vector<Instance> instances;
  std::vector<MovingInstanceGeometry> moving;           // numbered after the instances
  std::vector<std::optional<DeformingMesh>> deforming;  // one a mesh, or none at all
  std::optional<CameraMotion> camera_motion;
  std::vector<MeshView> meshes;
  std::vector<std::uint32_t> sphere_shapes;
  std::vector<std::uint32_t> disk_shapes;
  std::vector<std::uint32_t> cylinder_shapes;
  BsdfTables bsdf_tables;           // that the materials point to
  std::vector<Material> materials;  // one a BSDF of the description
  std::vector<Texture> textures;
  std::vector<Emitter> emitters;      // one an area light, or none if no texture emits and no bodies overlap
  std::vector<Medium> media;          // those with any extinction
  std::vector<PhaseFunction> phases;  // one a medium
  Nesting nesting;
  bool count_null_interfaces = true;  // see SceneDescription, as the next
  bool hides_emitters = false;
  bool lets_light_pass = false;  // some surface may, straight on
  Lights lights;
  Sensor sensor;
  PixelFilter filter;
  FilmDescription film;
  std::size_t dropped_triangles = 0;  // of no area, so that no ray can meet them

  /// The nearest surface that the ray meets, at a time from 0 to 1 if anything moves. E prunes kinds of shapes that the
  /// scene cannot hold. A Guard lives while Embree searches.
  template <Effects E, class Guard = Unguarded>
  [[nodiscard]] MeetingOf<E> closest(const Ray& ray, float time) const noexcept;
  /// The interaction with what was hit in an instance.
  template <Effects E>
  [[nodiscard, gnu::noinline]] MeetingOf<E> seen_in(const Hit& hit, const Ray& ray, float time) const noexcept;
  /// The corners of a triangle of a mesh, in the mesh's own space.
  [[nodiscard]] std::array<Vec3f, 3> corners(std::uint32_t mesh, std::uint32_t primitive, float time) const noexcept;
  /// Whether anything that rays meet is elsewhere at another time.
  [[nodiscard]] bool moves() const noexcept { return accel.moves(); }
  /// Whether anything stands in the way of the ray.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE bool occluded(const Ray& ray, float time) const noexcept {
    return accel.occluded<E>(ray, time);
  }
  /// An instance by its number, as it is at the time if it moves.
  [[nodiscard]] Instance instance_at(std::uint32_t number, float time) const noexcept {
    if (number < instances.size()) return instances[number];
    const auto& [group, to_world] = moving[number - instances.size()];
    return {group, to_world.at(static_cast<double>(time))};
  }
  /// Recomputes a hit point in float64. `ray` is in the local space of the shape range. `geometries()` gives the
  /// range's geometries, and is called only where they are needed, since the call is not free.
  template <Effects E, class GeometriesOf>
  [[nodiscard]] detail::SurfacePoint recompute_hit(const ShapeRange& set, GeometriesOf&& geometries,
                                                   const PrimitiveId& id, const RayD& ray, float time) const noexcept;

  /// Material on the side that the interaction is on; kNone where that side absorbs.
  [[nodiscard]] std::uint32_t material(const Interaction& it) const noexcept {
    return surfaces[it.shape].bsdf[it.front ? 0 : 1];
  }
  /// The part of a material that is picked at the point: a leaf or nothing.
  [[nodiscard]] std::uint32_t choose_component(std::uint32_t material, const Interaction& it, double u) const noexcept;
  /// BSDF of a leaf at the point, whose frame it may bend. One that textures make is put in `own`.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE const Bsdf& bsdf(std::uint32_t leaf, Interaction& it, std::optional<Bsdf>& own,
                                                  float time) const noexcept {
    const Material& material = materials[leaf];
    if constexpr (E.normal_maps)
      if (material.bend) bend(*material.bend, it, E.motion ? time : 0);
    if constexpr (E.textures)
      if (!material.bindings.empty()) return material.at(textures, place(it), own);
    return material.bsdf;
  }
  [[nodiscard]] Derivatives derivatives(const Interaction& it, float time) const noexcept;
  /// Bends the shading frame of the interaction.
  void bend(const NormalMap& bend, Interaction& it, float time) const noexcept;
  /// Where textures are looked up for a point of a textured surface. A mesh that has no texture coordinates takes its
  /// triangles' barycentric ones.
  [[nodiscard]] TextureCoords place(const Interaction& it) const noexcept {
    return place(it.shape, it.primitive, it.place);
  }
  [[nodiscard]] TextureCoords place(std::uint32_t shape, std::uint32_t primitive, Point2f on_primitive) const noexcept;
  /// What the front of an emissive surface sends back along the ray.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Spectrum radiance(const Interaction& it) const noexcept {
    const Surface& surface = surfaces[it.shape];
    if constexpr (E.textures)
      if (surface.emission != kNone) return surface.radiance * eval(textures[surface.emission], place(it));
    return surface.radiance;
  }
  /// Radiance of a light sample, times the texture that a spot light projects if it has one.
  [[nodiscard]] Spectrum projected(const LightSample<float>& sample) const noexcept;
  /// Radiance of a light sample, times the emitter's texture if it has one.
  [[nodiscard]] Spectrum radiance_of(const LightSample<float>& sample) const noexcept;
  /// The same at a time, if it may move.
  [[nodiscard]] Spectrum radiance_of(const LightSample<float>& sample, float time) const noexcept;
  /// The emitter of a light sample if its emission has a texture; null otherwise.
  [[nodiscard]] const Emitter* textured_emitter(const LightSample<float>& sample) const noexcept;
  /// The dielectrics and the medium that hold the camera at a time.
  [[nodiscard]] CameraMedium beginning(float time) const noexcept;
  /// Index in `lights` of the emissive primitive that the interaction is on.
  [[nodiscard]] std::uint32_t light_of(const Interaction& it) const noexcept {
    const Surface& surface = surfaces[it.shape];
    return surface.first_light + (surface.light_per_primitive ? it.primitive : 0);
  }
  [[nodiscard]] std::size_t triangle_count() const noexcept;
  /// Bytes held for geometry, its acceleration structure, lights and textures.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

template <Effects E, class Guard>
EQUALTIME_INLINE MeetingOf<E> Scene::closest(const Ray& ray, float time) const noexcept {
  Optional<Hit> hit = [&]() noexcept {
    [[maybe_unused]] const Guard guard;
    return accel.closest<E>(ray, time);
  }();
  if (!hit) return {};
  if constexpr (E.instances || E.motion)
    if (hit->instance != kNotInstanced) return seen_in<E>(*hit, ray, time);
  const auto own = [this]() noexcept -> const Geometries& { return accel.geometries(); };
  return detail::make_meeting<E>(recompute_hit<E>(top, own, hit->id, RayD(ray), time), ray);
}

template <Effects E>
MeetingOf<E> Scene::seen_in(const Hit& hit, const Ray& ray, float time) const noexcept {
  const Instance instance = instance_at(hit.instance, time);
  const std::uint32_t group = instance.group();
  const auto grouped = [&]() noexcept -> const Geometries& { return accel.groups()[group]; };
  const detail::SurfacePoint point =
      instance.placed(recompute_hit<E>(groups[group], grouped, hit.id, instance.to_local(RayD(ray)), time));
  MeetingOf<E> meeting = detail::make_meeting<E>(point, ray);
  surface(meeting)->instance = hit.instance;
  return meeting;
}

template <Effects E, class GeometriesOf>
EQUALTIME_INLINE detail::SurfacePoint Scene::recompute_hit(const ShapeRange& set, GeometriesOf&& geometries,
                                                           const PrimitiveId& id, const RayD& ray,
                                                           [[maybe_unused]] float time) const noexcept {
  if constexpr (E.analytic_shapes) {
    const std::uint32_t i = id.primitive;
    if (id.geometry == set.mesh_count) {
      const std::uint32_t shape = sphere_shapes[set.first_sphere + i];
      return detail::recompute_hit<E>(geometries().spheres[i], surfaces[shape], ray, shape);
    }
    if (id.geometry == set.mesh_count + 1) {
      const std::uint32_t shape = disk_shapes[set.first_disk + i];
      return detail::recompute_hit<E>(geometries().disks[i], surfaces[shape], ray, shape);
    }
    if (id.geometry > set.mesh_count) {
      const std::uint32_t shape = cylinder_shapes[set.first_cylinder + i];
      return detail::recompute_hit<E>(geometries().cylinders[i], surfaces[shape], ray, shape);
    }
  }
  std::uint32_t mesh = id.geometry;
  if constexpr (E.instances || E.motion) mesh += set.first_mesh;
  if constexpr (E.motion)
    if (!deforming.empty() && deforming[mesh])
      return recompute_deforming_hit<E>(*deforming[mesh], meshes[mesh], ray, id.primitive, time);
  return detail::recompute_hit<E>(meshes[mesh], ray, id.primitive);
}

}  // namespace equaltime
