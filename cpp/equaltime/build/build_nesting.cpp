#include "equaltime/build/build_nesting.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "equaltime/accel/accel.h"
#include "equaltime/build/build_meshes.h"
#include "equaltime/math/box_tree.h"
#include "equaltime/scene/material.h"
#include "equaltime/sensors/sensor.h"
#include "equaltime/shapes/winding.h"

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
  if (const auto* smooth = std::get_if<Dielectric<float>>(&m.bsdf)) return smooth->ior;
  if (const auto* rough = std::get_if<RoughDielectric<float>>(&m.bsdf)) return rough->ior;
  const auto* principled = std::get_if<Principled>(&m.bsdf);
  if ((principled != nullptr && principled->transmits) || std::holds_alternative<ThinDielectric<float>>(m.bsdf))
    fail(shape, "a priority is for smooth and rough dielectrics, for what is opaque and for nothing");
  return 1;
}

/// Calls f with each shape of a set that may be closed.
template <class F>
void each_of(const ShapesToNest& shapes, const ShapeRange& set, const Geometries& all, F&& f) {
  for (std::size_t i = 0; i < all.meshes.size(); ++i)
    f(ClosedShape{shapes.mesh_shapes[set.first_mesh + i], &all.meshes[i], nullptr});
  constexpr std::size_t kSpheres = AnalyticShapes::place_of<Sphere<float>>;
  const std::vector<Sphere<float>>& spheres = all.of<Sphere<float>>();
  for (std::size_t i = 0; i < spheres.size(); ++i)
    f(ClosedShape{shapes.analytic_shapes[kSpheres][set.first[kSpheres] + i], nullptr, &spheres[i]});
}

/// The box around all the places of a shape, in its own space.
Bounds bounds_of(const ClosedShape& closed) noexcept {
  Bounds b;
  if (closed.mesh != nullptr) {
    const auto include = [&](const std::vector<Vec3f>& vertices) {  // of which the last may be there for Embree alone
      for (const Triangle& triangle : closed.mesh->triangles)
        for (const std::uint32_t i : triangle) b.include(Vec3d(vertices[i]));
    };
    include(closed.mesh->vertices);
    for (const std::vector<Vec3f>& later : closed.mesh->later) include(later);
  }
  if (closed.sphere != nullptr) b.include(box_of(*closed.sphere));
  return b;
}

/// A shape with a priority.
struct Ranked {
  int priority;
  std::uint32_t shape;
  Bounds bounds;
};

constexpr const char* kInside = "a priority is for what has an inside: meshes and spheres";

bool has_inside(const ShapeDescription& shape) noexcept {
  return std::holds_alternative<MeshDescription>(shape) || std::holds_alternative<SphereDescription>(shape);
}

/// Adds the shapes of groups that have one instance, which moves.
void add_moving(const SceneDescription& d, const ShapesToNest& shapes, std::vector<Ranked>& ranked) {
  std::vector<const Motion*> motions(d.groups.size());
  for (const auto& [group, to_world] : shapes.moving) motions[group] = &to_world;
  std::size_t first = d.shapes.size();
  for (std::uint32_t group = 0; group < d.groups.size(); ++group) {
    const std::vector<ShapeDescription>& parts = d.groups[group].shapes;
    const std::optional<std::size_t> owner = shapes.only_instances[group];
    const bool moves = owner && motions[group] != nullptr;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!priority_of(parts[i])) continue;
      if (!moves) fail(first + i, "a shape of a group has no priority");
      if (!has_inside(parts[i])) fail(*owner, kInside);
    }
    if (moves)
      each_of(shapes, shapes.group_sets[group], shapes.groups[group], [&](const ClosedShape& closed) {
        if (const auto priority = priority_of(parts[closed.shape - first]))
          ranked.push_back({*priority, closed.shape, motions[group]->swept(bounds_of(closed))});
      });
    first += parts.size();
  }
}

std::vector<Ranked> ranked_shapes(const SceneDescription& d, const ShapesToNest& shapes) {
  std::vector<Ranked> ranked;
  for (std::size_t i = 0; i < d.shapes.size(); ++i)
    if (priority_of(d.shapes[i]) && !has_inside(d.shapes[i])) fail(i, kInside);
  each_of(shapes, shapes.top_set, shapes.top, [&](const ClosedShape& closed) {
    if (const auto priority = priority_of(d.shapes[closed.shape]))
      ranked.push_back({*priority, closed.shape, bounds_of(closed)});
  });
  add_moving(d, shapes, ranked);
  return ranked;
}

/// The shapes whose boxes touch the box of another.
std::vector<Ranked> overlapping(const std::vector<Ranked>& all) {
  std::vector<Bounds> boxes;
  boxes.reserve(all.size());
  for (const Ranked& r : all) boxes.push_back(r.bounds);
  const BoxTree tree(boxes);
  std::vector<Ranked> ranked;
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    bool alone = true;
    tree.each_touching(boxes[i], [&](std::uint32_t other) { return alone = alone && other == i; });
    if (!alone) ranked.push_back(all[i]);
  }
  return ranked;
}

void rank_dielectrics(const SceneDescription& d, const ShapesToNest& shapes, Nesting& nesting,
                      std::vector<Surface>& surfaces) {
  std::vector<Ranked> ranked = overlapping(ranked_shapes(d, shapes));
  std::ranges::sort(ranked, {}, [](const Ranked& r) { return std::pair(r.priority, r.shape); });
  if (ranked.size() > kMaxDielectrics)
    fail(ranked.back().shape,
         "no more than " + std::to_string(kMaxDielectrics) + " shapes that overlap have priorities");
  for (const Ranked& r : ranked) {
    Surface& surface = surfaces[r.shape];
    surface.media.rank = static_cast<std::uint8_t>(nesting.dielectrics.size());
    const std::uint32_t material = surface.material[0] != kNone ? surface.material[0] : surface.material[1];
    nesting.dielectrics.push_back(
        {surface.media.sides[1], material == kNone ? 1.0F : index_of(shapes, material, r.shape)});
  }
}

/// Finds what holds the camera: all dielectrics, and the medium of the smallest other closed shape.
class Search {
 public:
  Search(Nesting& nesting, const ShapesToNest& shapes, const std::vector<Surface>& surfaces, bool medium_is_said)
      : nesting_(nesting),
        shapes_(shapes),
        surfaces_(surfaces),
        medium_is_said_(medium_is_said),
        first_(shapes.camera_motion ? shapes.camera_motion->place(0) : nesting.camera) {
    if (shapes.camera_motion)
      reach_ = shapes.camera_motion->places();
    else
      reach_.include(nesting.camera);
  }

  /// A shape that may be closed and hold the camera, with its box.
  struct Candidate {
    ClosedShape closed;
    Bounds box;
  };
  /// The candidates of a set. A shared one, of a group, gets an index.
  [[nodiscard]] std::vector<Candidate> candidates(const ShapeRange& set, const Geometries& all, bool shared) const {
    std::vector<Candidate> found;
    each_of(shapes_, set, all, [&](ClosedShape closed) {
      const Surface& surface = surfaces_[closed.shape];
      if (surface.media.rank == kNoRank && (!surface.media.sets_medium || medium_is_said_)) return;
      const Bounds box = bounds_of(closed);
      if (closed.mesh != nullptr && (shared || changes(closed)))
        closed.index = std::make_shared<ClosedMesh>(*closed.mesh, box);
      found.push_back({std::move(closed), box});
    });
    return found;
  }

  /// Tests the shapes of an instance, which is `in` when the shutter opens. `placed` maps a local box to the scene.
  template <class Placed>
  void look_at(const std::vector<Candidate>& all, std::uint32_t instance, const Instance* in, bool moves,
               Placed&& placed) {
    for (const Candidate& candidate : all) {
      ClosedShape closed = candidate.closed;
      closed.instance = instance;
      const bool near = touch(placed(candidate.box), reach_);
      if (near && closed.index) closed.index->prepare();
      if (near && (moves || changes(closed)))
        nesting_.time_dependent.push_back(std::move(closed));
      else
        closed.include_if_inside(nesting_.fixed, surfaces_[closed.shape], first_, in, 0);
    }
  }

 private:
  /// Whether the shape may hold the camera at one time and not at another.
  [[nodiscard]] bool changes(const ClosedShape& closed) const noexcept {
    return shapes_.camera_motion || (closed.mesh != nullptr && !closed.mesh->later.empty());
  }

  Nesting& nesting_;
  const ShapesToNest& shapes_;
  const std::vector<Surface>& surfaces_;
  bool medium_is_said_;
  Vec3d first_;   // the camera when the shutter opens
  Bounds reach_;  // around all positions of the camera
};

}  // namespace

Nesting make_nesting(const SceneDescription& d, const ShapesToNest& shapes, const Vec3d& camera,
                     std::uint32_t camera_medium, std::vector<Surface>& surfaces) {
  Nesting nesting{{}, {0, camera_medium}, {}, camera};
  rank_dielectrics(d, shapes, nesting, surfaces);
  Search search(nesting, shapes, surfaces, d.camera_medium.has_value());
  search.look_at(search.candidates(shapes.top_set, shapes.top, false), kNone, nullptr, false,
                 [](const Bounds& own) { return own; });
  std::vector<std::vector<Search::Candidate>> grouped;
  grouped.reserve(shapes.groups.size());
  for (std::size_t i = 0; i < shapes.groups.size(); ++i)
    grouped.push_back(search.candidates(shapes.group_sets[i], shapes.groups[i], true));
  for (std::size_t i = 0; i < shapes.instances.size(); ++i) {
    const Instance& instance = shapes.instances[i];
    search.look_at(grouped[instance.group()], static_cast<std::uint32_t>(i), &instance, false,
                   [&](const Bounds& own) { return instance.placed(own); });
  }
  for (std::size_t i = 0; i < shapes.moving.size(); ++i) {
    const auto& [group, to_world] = shapes.moving[i];
    const Instance at_first(group, to_world.at(0));
    search.look_at(grouped[group], static_cast<std::uint32_t>(shapes.instances.size() + i), &at_first, true,
                   [&path = to_world](const Bounds& own) { return path.swept(own); });
  }
  return nesting;
}

}  // namespace equaltime
