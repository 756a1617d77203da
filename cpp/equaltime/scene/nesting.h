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

#include "equaltime/base/index.h"
#include "equaltime/bsdfs/bsdf.h"
#include "equaltime/math/numeric.h"
#include "equaltime/scene/surface.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

/// What fills a shape with a priority.
struct Body {
  std::uint32_t medium;  // kNone: vacuum
  float ior;             // over that of what is round all bodies
};

class ClosedMesh;
class Instance;

/// A set of bodies by their ranks: the higher, the higher the priority.
using DielectricSet = std::uint64_t;
inline constexpr std::size_t kMostBodies = 64;

[[nodiscard]] constexpr DielectricSet only(std::uint8_t rank) noexcept { return DielectricSet{1} << rank; }
/// Where a path begins.
struct CameraMedium {
  DielectricSet bodies = 0;      // those that the camera is in
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
  void look(CameraMedium& beginning, const Surface& surface, const Vec3d& camera, const Instance* in,
            float time) const noexcept;
};

/// The rank of the body that is there; of a set that is not empty.
[[nodiscard]] constexpr int highest(DielectricSet bodies) noexcept {
  return static_cast<int>(std::bit_width(bodies)) - 1;
}

struct Nesting {
  std::vector<Body> bodies = {};            // by rank; empty where none overlap
  CameraMedium always = {};                 // by all shapes that the camera is in always or never
  std::vector<ClosedShape> sometimes = {};  // the others
  Vec3d camera = {};                        // if it does not move

  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// The BSDF of a body's surface, inside another body of so large an index.
[[nodiscard]] Bsdf with_exterior_ior(const Bsdf& bsdf, float outside) noexcept;

}  // namespace equaltime
