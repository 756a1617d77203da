// Accel: nearest hit and occlusion over triangle meshes (Embree), spheres, disks and cylinders (analytic, float64,
// inside its BVH; walls and a few moving instances beside it). The only place that knows Embree. Immutable once built
// and safe to query by any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "equaltime/base/optional.h"
#include "equaltime/math/motion.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

/// Which primitive was hit. Meshes are numbered as given; then come all spheres as one group, all disks, all
/// cylinders.
struct PrimitiveId {
  std::uint32_t geometry;
  std::uint32_t primitive;
};

/// All that rays may meet. The order of its members is that of PrimitiveId::geometry.
struct Geometries {
  std::vector<TriangleMesh> meshes;
  std::vector<SphereGeometry> spheres;
  std::vector<DiskGeometry> disks;
  std::vector<CylinderGeometry> cylinders;
};

/// A group of geometries that is seen once more. Its own space is taken to that of all by a 3x4 matrix, column by
/// column: exactly this one, in float32.
struct InstanceGeometry {
  std::uint32_t group;
  std::array<float, 12> to_world;
};

/// The same where the matrix changes with time: its rays are taken to the group's space by this class itself, in
/// float64, so that whoever computes the point from the same motion knows exactly which ray was traced.
struct MovingInstanceGeometry {
  std::uint32_t group;
  Motion to_world;
};

/// Which primitive was hit, and in which instance of its group; kNotInstanced if it is in none. Moving instances are
/// numbered after the others.
struct InstancedId {
  std::uint32_t instance;
  PrimitiveId id;
};
inline constexpr std::uint32_t kNotInstanced = ~std::uint32_t{0};

/// Robust is watertight at shared edges; fast trades that for speed, and is a named choice.
enum class Intersection : std::uint8_t { robust, fast };

class Accel {
 public:
  explicit Accel(Geometries geometries, Intersection mode = Intersection::robust, std::vector<Geometries> groups = {},
                 const std::vector<InstanceGeometry>& instances = {},
                 const std::vector<MovingInstanceGeometry>& moving = {});
  ~Accel();
  Accel(Accel&&) noexcept;
  Accel& operator=(Accel&&) noexcept;

  /// Nearest primitive that the ray meets at t in (0, t_max).
  [[nodiscard]] EQUALTIME_INLINE Optional<PrimitiveId> intersect(const Ray& ray) const noexcept {
    const auto& [o, d, t_max] = ray;
    return intersect(o.x, o.y, o.z, d.x, d.y, d.z, t_max);
  }
  /// The same where there are instances.
  [[nodiscard]] Optional<InstancedId> intersect_instances(const Ray& ray) const noexcept;
  /// The same where something moves, at a time from 0, when the shutter opens, to 1, when it closes.
  [[nodiscard]] Optional<InstancedId> intersect_at(const Ray& ray, float time) const noexcept;
  [[nodiscard]] bool occluded_at(const Ray& ray, float time) const noexcept;
  [[nodiscard]] EQUALTIME_INLINE bool occluded(const Ray& ray) const noexcept {
    const auto& [o, d, t_max] = ray;
    return occluded(o.x, o.y, o.z, d.x, d.y, d.z, t_max);
  }

  /// Whether this thread traced a ray since it last asked that Embree does not take: one with NaN, or that begins
  /// beyond `reach`. Such a ray meets nothing, so that whatever was made of it counts for nothing.
  [[nodiscard]] static bool refused_ray() noexcept { return std::exchange(refused_, false); }
  /// The largest coordinate of an origin that is still within Embree's limits in the space of the instance's group.
  [[nodiscard]] static double reach(const InstanceGeometry& instance) noexcept;

  [[nodiscard]] const Geometries& geometries() const noexcept;
  [[nodiscard]] const std::vector<Geometries>& groups() const noexcept;
  /// The acceleration structure's own memory, Embree's as it reports it, without the primitives.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Embree's version, for provenance.
  [[nodiscard]] static std::string version();

 private:
  friend void refuse_ray() noexcept;
  // Initial-exec: reading it takes one instruction.
  [[gnu::tls_model("initial-exec")]] static constinit thread_local bool refused_;

  // Each number in a register of its own: see EQUALTIME_INLINE.
  [[nodiscard]] Optional<PrimitiveId> intersect(float ox, float oy, float oz, float dx, float dy, float dz,
                                                float t_max) const noexcept;
  [[nodiscard]] bool occluded(float ox, float oy, float oz, float dx, float dy, float dz, float t_max) const noexcept;

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace equaltime
