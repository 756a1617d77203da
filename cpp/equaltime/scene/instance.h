// Instance: one placement of a group of shapes, static or at one time. Hit points are computed in the group's space, in
// float64, and transformed to the scene's. Their offset also bounds the error of Embree's transform of the ray.
#pragma once

#include "equaltime/scene/recompute_hit.h"

namespace equaltime {

/// The primitives of the scene itself, or of one group, as ranges of the lists in SceneGeometry.
struct ShapeRange {
  std::uint32_t first_mesh = 0, mesh_count = 0;
  std::array<std::uint32_t, AnalyticShapes::size> first = {};  // of each kind of analytic shapes
};

class Instance {
 public:
  /// `to_world` as Accel has it: three columns, and where the group's origin goes; its determinant is not 0.
  explicit Instance(const InstanceGeometry& geometry) noexcept;
  /// A moving instance at one time. Embree gets rays that were transformed in float64 and then rounded.
  Instance(std::uint32_t group, const AffineMap& now) noexcept;

  [[nodiscard]] std::uint32_t group() const noexcept { return group_; }
  [[nodiscard]] RayD to_local(const RayD& ray) const noexcept;
  [[nodiscard]] Vec3f to_world(const Vec3f& direction) const noexcept;
  /// Volume in the scene's space over volume in the group's.
  [[nodiscard]] double magnification() const noexcept;
  /// Bound of the distance, along the normal n, between a point p and Embree's hit point.
  [[nodiscard]] float position_error(const Vec3f& p, const Vec3f& n) const noexcept;
  /// The box, in the scene's space, around a box of the group's space.
  [[nodiscard]] Bounds placed(const Bounds& local) const noexcept;
  /// Transforms a hit point from the group's space to the scene's.
  [[nodiscard]] detail::SurfacePoint placed(const detail::SurfacePoint& local) const noexcept;

 private:
  std::uint32_t group_;
  Vec3d columns_[3], origin_;  // to_world
  Vec3d rows_[3];              // of its linear part's inverse
  Vec3d error_[3];             // error bound of the ray transform, per matrix entry and unit of |p| + |origin|
};

}  // namespace equaltime
