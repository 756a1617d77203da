#include "scene/nesting.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "accel/accel.h"
#include "scene/build_meshes.h"
#include "scene/description.h"
#include "scene/material.h"
#include "scene/winding.h"

namespace equaltime {

namespace {

std::optional<int> priority_of(const ShapeDescription& shape) noexcept {
  return std::visit(
      [](const auto& s) -> std::optional<int> {
        if constexpr (requires { s.surface; }) return s.surface.priority;
        return std::nullopt;
      },
      shape);
}

/// The index of a dielectric, or the largest of those in a mixture; 1 for all else.
float index_of(const ShapesToNest& shapes, std::uint32_t material, std::size_t shape) {
  const Material& m = shapes.materials[material];
  if (m.kind == Material::Kind::mixture)
    return std::max(index_of(shapes, m.parts[0], shape), index_of(shapes, m.parts[1], shape));
  if (const auto* smooth = std::get_if<Dielectric>(&m.bsdf)) return smooth->ior;
  if (const auto* rough = std::get_if<RoughDielectric>(&m.bsdf)) return rough->ior;
  const auto* principled = std::get_if<Principled>(&m.bsdf);
  if ((principled != nullptr && principled->transmits) || std::holds_alternative<ThinDielectric>(m.bsdf))
    fail(shape, "a priority is for smooth and rough dielectrics, for what is opaque and for nothing");
  return 1;
}

struct Place {
  const TriangleMesh* mesh = nullptr;
  const SphereGeometry* sphere = nullptr;
};

/// Calls f with each shape of a set that may be closed.
template <class F>
void each_of(const ShapesToNest& shapes, const SetOfShapes& set, const Geometries& all, F&& f) {
  for (std::size_t i = 0; i < all.meshes.size(); ++i) f(shapes.mesh_shapes[set.first_mesh + i], Place{&all.meshes[i]});
  for (std::size_t i = 0; i < all.spheres.size(); ++i)
    f(shapes.sphere_shapes[set.first_sphere + i], Place{nullptr, &all.spheres[i]});
}

Bounds bounds_of(const Place& place) noexcept {
  Bounds b;
  if (place.mesh != nullptr)
    for (const Vec3f& v : place.mesh->vertices) b.include(Vec3d(v));
  if (place.sphere != nullptr) {
    const Vec3d half = Vec3d{1, 1, 1} * place.sphere->radius;
    b.include(place.sphere->center - half);
    b.include(place.sphere->center + half);
  }
  return b;
}

bool touch(const Bounds& a, const Bounds& b) noexcept {
  return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z &&
         b.lo.z <= a.hi.z;
}

/// A shape with a priority.
struct Ranked {
  int priority;
  std::uint32_t shape;
  Bounds bounds;
};

std::vector<Ranked> ranked_shapes(const SceneDescription& d, const ShapesToNest& shapes) {
  std::vector<Ranked> ranked;
  each_of(shapes, shapes.top_set, shapes.top, [&](std::uint32_t shape, const Place& place) {
    const auto priority = priority_of(d.shapes[shape]);
    const bool flat = std::holds_alternative<RectangleDescription>(d.shapes[shape]);
    if (priority && !flat) ranked.push_back({*priority, shape, bounds_of(place)});
  });
  const auto has = [&](std::size_t shape) {
    return std::ranges::any_of(ranked, [shape](const Ranked& r) { return r.shape == shape; });
  };
  for (std::size_t i = 0; i < d.shapes.size(); ++i)
    if (priority_of(d.shapes[i]) && !has(i)) fail(i, "a priority is for what has an inside: meshes and spheres");
  std::size_t shape = d.shapes.size();
  for (const GroupDescription& group : d.groups)
    for (const ShapeDescription& part : group.shapes) {
      if (priority_of(part)) fail(shape, "a shape of a group has no priority");
      ++shape;
    }
  return ranked;
}

void rank_bodies(const SceneDescription& d, const ShapesToNest& shapes, Nesting& nesting,
                 std::vector<Surface>& surfaces) {
  const std::vector<Ranked> all = ranked_shapes(d, shapes);
  std::vector<Ranked> ranked;
  for (const Ranked& r : all)
    if (std::ranges::any_of(all, [&](const Ranked& o) { return o.shape != r.shape && touch(o.bounds, r.bounds); }))
      ranked.push_back(r);
  std::ranges::sort(ranked, {}, [](const Ranked& r) { return std::pair(r.priority, r.shape); });
  if (ranked.size() > kMostBodies)
    fail(ranked.back().shape, "no more than " + std::to_string(kMostBodies) + " shapes that overlap have priorities");
  for (const Ranked& r : ranked) {
    Surface& surface = surfaces[r.shape];
    surface.rank = static_cast<std::uint8_t>(nesting.bodies.size());
    const std::uint32_t material = surface.bsdf[0] != kNone ? surface.bsdf[0] : surface.bsdf[1];
    nesting.bodies.push_back({surface.media[1], material == kNone ? 1.0F : index_of(shapes, material, r.shape)});
  }
}

/// Where the camera is, by all closed shapes: the bodies, and the medium of the smallest other shape.
class Search {
 public:
  Search(Nesting& nesting, const std::vector<Surface>& surfaces, bool medium_is_said)
      : nesting_(nesting), surfaces_(surfaces), medium_is_said_(medium_is_said) {}

  void look_at(std::uint32_t shape, const Place& place, const Vec3d& camera) {
    const Surface& surface = surfaces_[shape];
    const bool ranked = surface.rank != kNoRank;
    if (!ranked && (!surface.bounds_media || medium_is_said_)) return;
    const auto found = place.mesh != nullptr ? enclosure(*place.mesh, camera)
                                             : std::optional(enclosure(*place.sphere, surface.flipped, camera));
    const bool turned = place.mesh != nullptr && surface.flipped;
    if (!found || found->behind == turned) return;
    if (ranked) nesting_.camera |= only(surface.rank);
    if (ranked || !(found->volume < smallest_)) return;
    smallest_ = found->volume;
    nesting_.camera_medium = surface.media[1];
  }

 private:
  Nesting& nesting_;
  const std::vector<Surface>& surfaces_;
  bool medium_is_said_;
  double smallest_ = static_cast<double>(kInfinity);
};

}  // namespace

Bsdf within(const Bsdf& bsdf, float outside) noexcept {
  const auto over = [outside](float ior) noexcept {
    return static_cast<float>(static_cast<double>(ior) / static_cast<double>(outside));
  };
  if (const auto* smooth = std::get_if<Dielectric>(&bsdf)) {
    Dielectric d = *smooth;
    d.ior = over(d.ior);
    return d;
  }
  const auto* rough = std::get_if<RoughDielectric>(&bsdf);
  if (rough == nullptr) return bsdf;
  RoughDielectric d = *rough;
  d.ior = over(d.ior);
  if (d.ior != 1) return d;
  Dielectric clear{DielectricDescription{}};  // facets between equal indices turn nothing
  clear.ior = 1;
  clear.specular_transmittance = d.specular_transmittance;
  return clear;
}

Nesting make_nesting(const SceneDescription& d, const ShapesToNest& shapes, const Vec3d& camera,
                     std::uint32_t camera_medium, std::vector<Surface>& surfaces) {
  Nesting nesting{{}, 0, camera_medium};
  rank_bodies(d, shapes, nesting, surfaces);
  const auto moves = [](const ShapeDescription& shape) {
    const auto* instance = std::get_if<InstanceDescription>(&shape);
    return instance != nullptr && !instance->keys.empty();
  };
  if (!nesting.bodies.empty() && (!d.sensor_keys.empty() || std::any_of(d.shapes.begin(), d.shapes.end(), moves)))
    throw std::invalid_argument("where bodies overlap by priority, nothing can move, and nor can the camera");
  Search search(nesting, surfaces, d.camera_medium.has_value());
  const auto in = [&](const SetOfShapes& set, const Geometries& all, const Vec3d& place) {
    each_of(shapes, set, all, [&](std::uint32_t shape, const Place& at) { search.look_at(shape, at, place); });
  };
  in(shapes.top_set, shapes.top, camera);
  for (const Instance& instance : shapes.instances)
    in(shapes.group_sets[instance.group()], shapes.groups[instance.group()],
       instance.to_local({camera, {0, 0, 1}, 1}).origin);
  return nesting;
}

}  // namespace equaltime
