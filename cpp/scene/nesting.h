// Nesting: which bodies a point is in, for shapes with a priority, and which medium. Where bodies overlap, the one of
// the highest priority is there, and the surfaces of the others are not (Schmidt & Budge 2002, "Simple nested
// dielectrics in ray traced images"). A path keeps the set of bodies that it is in; it begins with those that the
// camera is in, by the winding numbers of closed shapes round it, never by counting the hits of rays.
#pragma once

#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "math/numeric.h"
#include "scene/bsdf.h"
#include "scene/surface.h"

namespace equaltime {

/// What fills a shape with a priority.
struct Body {
  std::uint32_t medium;  // kNone: vacuum
  float ior;             // over that of what is round all bodies
};

class ClosedMesh;
class Instance;

/// A set of bodies by their ranks: the higher, the higher the priority.
using Bodies = std::uint64_t;
inline constexpr std::size_t kMostBodies = 64;

[[nodiscard]] constexpr Bodies only(std::uint8_t rank) noexcept { return Bodies{1} << rank; }
/// Where a path begins.
struct Beginning {
  Bodies bodies = 0;             // those that the camera is in
  std::uint32_t medium = kNone;  // what is round it where no body is
  double smallest = kNowhere;    // the volume, in the scene's space, of the shape that has it

  static constexpr double kNowhere = static_cast<double>(kInfinity);
};

/// What may be closed.
struct ClosedShape {
  std::uint32_t shape = kNone;
  const TriangleMesh* mesh = nullptr;  // the accel's own, as the sphere
  const SphereGeometry* sphere = nullptr;
  std::shared_ptr<ClosedMesh> index = {};  // of the mesh, where many points or times are asked about
  std::uint32_t instance = kNone;          // that it is seen in, by its number, if any

  /// Notes whether the camera, at this place in the scene's space, is in it at a time. `in` is the instance as it is
  /// then; null if the shape is in none.
  void look(Beginning& beginning, const Surface& surface, const Vec3d& camera, const Instance* in,
            float time) const noexcept;
};

/// The rank of the body that is there; of a set that is not empty.
[[nodiscard]] constexpr int highest(Bodies bodies) noexcept { return static_cast<int>(std::bit_width(bodies)) - 1; }

struct Nesting {
  std::vector<Body> bodies = {};            // by rank; empty where none overlap
  Beginning always = {};                    // by all shapes that the camera is in always or never
  std::vector<ClosedShape> sometimes = {};  // the others
  Vec3d camera = {};                        // if it does not move

  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// The BSDF of a body's surface, inside another body of so large an index.
[[nodiscard]] Bsdf within(const Bsdf& bsdf, float outside) noexcept;

struct Material;
struct Geometries;
class CameraMotion;
struct MovingInstanceGeometry;
struct SetOfShapes;
struct SceneDescription;

/// The shapes of a scene while it is built.
struct ShapesToNest {
  const std::vector<Material>& materials;
  const Geometries& top;
  const std::vector<Geometries>& groups;
  const std::vector<Instance>& instances;
  const std::vector<MovingInstanceGeometry>& moving;
  const std::optional<CameraMotion>& camera_motion;
  const SetOfShapes& top_set;
  const std::vector<SetOfShapes>& group_sets;
  const std::vector<std::optional<std::size_t>>& only_instances;  // of each group
  const std::vector<std::uint32_t>&mesh_shapes, &sphere_shapes;
};

/// Gives ranks to the surfaces of shapes that have a priority and touch another that has, and finds where the camera
/// is, which stands at `camera` if it does not move. Throws std::invalid_argument that names a shape that cannot have a
/// priority.
[[nodiscard]] Nesting make_nesting(const SceneDescription& description, const ShapesToNest& shapes, const Vec3d& camera,
                                   std::uint32_t camera_medium, std::vector<Surface>& surfaces);

}  // namespace equaltime
