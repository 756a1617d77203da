// Motion: an affine map that changes between keys, over times from 0, when the shutter opens, to 1, when it closes.
// Each key is taken apart into a rotation after a symmetric stretch, and where the origin goes (Shoemake & Duff 1992).
// The origin and the stretch change linearly, the rotation turns at a steady pace, the shorter way round. All in
// float64.
#pragma once

#include <cstdint>
#include <vector>

#include "equaltime/math/bounds.h"
#include "equaltime/math/transform.h"

namespace equaltime {

/// An affine map at one time, with its inverse.
struct AffineMap {
  Vec3d columns[3];  // of its linear part
  Vec3d origin;      // where 0 goes
  Vec3d rows[3];     // of the linear part's inverse

  AffineMap(const Vec3d& x, const Vec3d& y, const Vec3d& z, const Vec3d& at) noexcept;

  [[nodiscard]] Vec3d vector(const Vec3d& v) const noexcept {
    return columns[0] * v.x + columns[1] * v.y + columns[2] * v.z;
  }
  [[nodiscard]] Vec3d point(const Vec3d& p) const noexcept { return origin + vector(p); }
  [[nodiscard]] Vec3d local_vector(const Vec3d& v) const noexcept {
    return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)};
  }
  [[nodiscard]] Vec3d local_point(const Vec3d& p) const noexcept { return local_vector(p - origin); }
  [[nodiscard]] bool mirrors() const noexcept { return dot(columns[0], cross(columns[1], columns[2])) < 0; }
  /// Normals go by the transposed inverse; not of unit length.
  [[nodiscard]] Vec3d normal(const Vec3d& n) const noexcept { return rows[0] * n.x + rows[1] * n.y + rows[2] * n.z; }
};

struct MotionKey {
  double time = 0;
  Transform to_world;
};

class Motion {
 public:
  /// Throws std::invalid_argument if there are no keys, if their times do not increase, or if one has no inverse or
  /// mirrors what another does not: on the way, all would be flat.
  explicit Motion(const std::vector<MotionKey>& keys);

  /// The same motion for spaces of other origins and units: `own` is what is 0 there now, and `scale` the unit.
  struct Space {
    Vec3d origin;
    double scale;
  };
  [[nodiscard]] Motion between(const Space& own, const Space& world) const;

  /// Returns the placement at a time. Before the first key, the first key's placement holds; after the last key, the
  /// last one's. Each thread keeps recent placements, because all rays of a path have one time.
  [[nodiscard]] AffineMap at(double time) const noexcept;

  /// Whether it does more than to move everything along.
  [[nodiscard]] bool turns() const noexcept;
  /// The box around a local box at a time.
  [[nodiscard]] Bounds bounds_at(const Bounds& local, double time) const noexcept;
  /// How far the points of a local box are at most, between two times, from where they were if each moved evenly.
  [[nodiscard]] double deviation(const Bounds& local, double begin, double end) const noexcept;
  /// Into how many equal parts the shutter is to be cut so that they are nearly there in each; at most 64.
  [[nodiscard]] unsigned parts(const Bounds& local) const noexcept;
  /// What the points of a local box pass through.
  [[nodiscard]] Bounds swept(const Bounds& local) const noexcept;
  /// Bytes held beside the object itself.
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return poses_.capacity() * sizeof(Pose); }

 private:
  struct Quaternion {
    double w, x, y, z;
  };
  struct Pose {
    double time;
    Vec3d position;
    Quaternion turn;
    Vec3d stretch, shear;  // the stretch's diagonal, and its (y, z), (z, x) and (x, y)
    double angle = 0;      // between this quaternion and the next; half that of the rotation
    double unit = 0;       // 1 / sin(angle), where the angle is not too small
  };

  [[nodiscard]] static Pose pose_of(const MotionKey& key, bool mirrored);
  [[nodiscard]] AffineMap computed_at(double time) const noexcept;
  [[nodiscard]] AffineMap placed(const Vec3d& position, const Quaternion& turn, const Vec3d& stretch,
                                 const Vec3d& shear) const noexcept;

  std::uint64_t id_;  // shared by motions that are equal
  std::vector<Pose> poses_;
  Vec3d pivot_;  // what is where the origin was when the keys were made
  bool mirrored_ = false;
};

}  // namespace equaltime
