// Nesting: the dielectrics and the medium that hold a point, for shapes with a priority. Where dielectrics overlap, the
// one of the highest priority fills the space, and the surfaces of the others are ignored there (Schmidt & Budge 2002,
// "Simple nested dielectrics in ray traced images"). A path carries the set of dielectrics that hold it. The set at the
// camera follows from the winding numbers of closed shapes around it, never from counting the hits of rays.
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

/// The interior of a shape with a priority.
struct NestedDielectric {
  std::uint32_t medium;  // kNone: vacuum
  float ior;             // relative to the space outside all dielectrics
};

class ClosedMesh;
class Instance;

/// A set of nested dielectrics, one bit for each rank. A higher priority has a higher rank.
using DielectricSet = std::uint64_t;
inline constexpr std::size_t kMaxDielectrics = 64;

[[nodiscard]] constexpr DielectricSet dielectric_bit(std::uint8_t rank) noexcept { return DielectricSet{1} << rank; }
/// Rank of the dielectric that fills the space; the set must not be empty.
[[nodiscard]] constexpr int top_rank(DielectricSet dielectrics) noexcept {
  return static_cast<int>(std::bit_width(dielectrics)) - 1;
}

/// Initial state of camera paths.
struct CameraMedium {
  DielectricSet dielectrics = 0;  // that hold the camera
  std::uint32_t medium = kNone;   // at the camera if no dielectric holds it; kNone: vacuum
  double smallest = kNowhere;     // volume, in the scene's space, of the shape that bounds this medium

  static constexpr double kNowhere = static_cast<double>(kInfinity);
};

/// A mesh or a sphere, which may be closed and hold the camera.
struct ClosedShape {
  std::uint32_t shape = kNone;
  const TriangleMesh* mesh = nullptr;      // Accel owns it, and the sphere
  const Sphere<float>* sphere = nullptr;   // null for a mesh
  std::shared_ptr<ClosedMesh> index = {};  // speeds up tests of a mesh at many points or times
  std::uint32_t instance = kNone;          // number of the instance that shows the shape; kNone: the scene itself

  /// Updates `state` if the shape holds the camera at a time. `camera` is in the scene's space. `in` is the instance at
  /// that time; null if the shape is in none.
  void include_if_inside(CameraMedium& state, const Surface& surface, const Vec3d& camera, const Instance* in,
                         float time) const noexcept;
};

struct Nesting {
  std::vector<NestedDielectric> dielectrics = {};  // by rank; empty if none overlap
  CameraMedium fixed = {};                         // by shapes that hold the camera at all times or never
  std::vector<ClosedShape> time_dependent = {};    // other shapes: tested for each path
  Vec3d camera = {};                               // position of the camera if it does not move

  [[nodiscard]] std::size_t memory_bytes() const noexcept;
};

/// The BSDF of a dielectric's surface with its index relative to an exterior dielectric of index `outside`.
[[nodiscard]] Bsdf with_exterior_ior(const Bsdf& bsdf, float outside) noexcept;

}  // namespace equaltime
