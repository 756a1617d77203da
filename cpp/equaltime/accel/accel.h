// Accel: nearest hit and occlusion over triangle meshes (Embree) and analytic shapes (float64, inside its BVH). Spheres
// that enclose the scene and a few moving instances are tested outside the BVH. The only place that knows Embree.
// Immutable once built and safe to query by any number of threads.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/motion.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

/// A primitive. `geometry` is the number of a mesh, as given; or, for an analytic shape, the count of meshes plus the
/// place of its kind in AnalyticShapes.
struct PrimitiveId {
  std::uint32_t geometry;
  std::uint32_t primitive;
};

/// All that rays may meet, in the order of PrimitiveId::geometry.
struct Geometries {
  std::vector<TriangleMesh> meshes;
  AnalyticShapes::Lists analytic = {};

  template <class Shape>
  [[nodiscard]] std::vector<Shape>& of() noexcept {
    return std::get<std::vector<Shape>>(analytic);
  }
  template <class Shape>
  [[nodiscard]] const std::vector<Shape>& of() const noexcept {
    return std::get<std::vector<Shape>>(analytic);
  }
};

/// An instance of a group of geometries that stands still. `to_world` is a 3x4 matrix, column by column; Embree takes
/// exactly these numbers.
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

/// A hit primitive, and the instance of its group in which the ray meets it: kNotInstanced outside of instances. Moving
/// instances are numbered after the others.
struct Hit {
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

  /// Nearest primitive that the ray meets at t in (0, t_max), at a time from 0, when the shutter opens, to 1, when it
  /// closes. E prunes instances and motion, which the scene must not have then.
  template <Effects E = kAllEffects>
  [[nodiscard]] EQUALTIME_INLINE Optional<Hit> closest(const Ray& ray, [[maybe_unused]] float time = 0) const noexcept {
    if constexpr (E.motion)
      if (moves_) return closest_moving(ray, time);
    if constexpr (E.instances)
      if (has_instances_) return closest_instanced(ray);
    const auto& [o, d, t_max] = ray;
    const Optional<PrimitiveId> id = closest_fixed(o.x, o.y, o.z, d.x, d.y, d.z, t_max);
    if (!id) return std::nullopt;
    return Hit{kNotInstanced, *id};
  }
  /// Whether the ray meets anything at t in (0, t_max), at a time.
  template <Effects E = kAllEffects>
  [[nodiscard]] EQUALTIME_INLINE bool occluded(const Ray& ray, [[maybe_unused]] float time = 0) const noexcept {
    if constexpr (E.motion)
      if (moves_) return occluded_moving(ray, time);
    const auto& [o, d, t_max] = ray;
    return occluded_fixed(o.x, o.y, o.z, d.x, d.y, d.z, t_max);
  }
  /// Both for many rays at once, in packets: one time and one result a ray. Where two primitives are equally near by
  /// float32, a packet may find the other one.
  void closest(std::span<const Ray> rays, std::span<const float> times, std::span<Optional<Hit>> hits) const noexcept;
  void occluded(std::span<const Ray> rays, std::span<const float> times, std::span<bool> blocked) const noexcept;

  /// Returns whether Embree refused a ray of this thread since the last call: one with NaN, or one that begins beyond
  /// `reach`. Such a ray has no nearest surface and counts as occluded, so what was made of it must not be used.
  [[nodiscard]] static bool take_refusal() noexcept { return std::exchange(refused_, false); }
  /// The largest coordinate of an origin that is still within Embree's limits in the space of the instance's group.
  [[nodiscard]] static double reach(const InstanceGeometry& instance) noexcept;

  /// Whether anything is elsewhere at another time.
  [[nodiscard]] bool moves() const noexcept { return moves_; }
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
  [[nodiscard]] Optional<PrimitiveId> closest_fixed(float ox, float oy, float oz, float dx, float dy, float dz,
                                                    float t_max) const noexcept;
  [[nodiscard]] bool occluded_fixed(float ox, float oy, float oz, float dx, float dy, float dz,
                                    float t_max) const noexcept;
  [[nodiscard]] Optional<Hit> closest_instanced(const Ray& ray) const noexcept;
  [[nodiscard]] Optional<Hit> closest_moving(const Ray& ray, float time) const noexcept;
  [[nodiscard]] bool occluded_moving(const Ray& ray, float time) const noexcept;

  struct Impl;
  std::unique_ptr<Impl> impl_;
  bool has_instances_ = false, moves_ = false;
};

}  // namespace equaltime
