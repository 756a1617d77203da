// Instance: a group of shapes seen once more, always or at one time. Points are met in the group's own space, in
// float64, and then taken to the scene's; the offset of a ray that leaves them bounds what Embree's transform of that
// ray may be off.
#pragma once

#include "equaltime/scene/meeting.h"

namespace equaltime {

/// Where the primitives of one set of geometries stand in the scene's lists.
struct ShapeRange {
  std::uint32_t first_mesh = 0, mesh_count = 0;
  std::uint32_t first_sphere = 0, first_disk = 0, first_cylinder = 0;
};

class Instance {
 public:
  /// `to_world` as Accel has it: three columns, and where the group's origin goes; its determinant is not 0.
  explicit Instance(const InstanceGeometry& geometry) noexcept;
  /// One that moves, where it is now: the ray that Embree gets was transformed in float64 and then rounded.
  Instance(std::uint32_t group, const AffineMap& now) noexcept;

  [[nodiscard]] std::uint32_t group() const noexcept { return group_; }
  [[nodiscard]] RayD to_local(const RayD& ray) const noexcept;
  [[nodiscard]] Vec3f to_world(const Vec3f& direction) const noexcept;
  /// How many times as large volumes are in the scene's space as in the group's.
  [[nodiscard]] double magnification() const noexcept;
  /// How far along its normal a point may be from where the ray of Embree meets it.
  [[nodiscard]] float doubt(const Vec3f& p, const Vec3f& n) const noexcept;
  /// The box around a box of the group's space.
  [[nodiscard]] Bounds placed(const Bounds& local) const noexcept;
  /// What was met in the group's space, in the scene's.
  [[nodiscard]] detail::SurfacePoint placed(const detail::SurfacePoint& local) const noexcept;

 private:
  std::uint32_t group_;
  Vec3d columns_[3], origin_;  // to_world
  Vec3d rows_[3];              // of its linear part's inverse
  Vec3d doubt_[3];             // of the ray's, entry by entry, for what is as long as the point and the origin together
};

}  // namespace equaltime
