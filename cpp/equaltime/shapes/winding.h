// Winding numbers: whether a point is inside a closed mesh, from the solid angles of all its triangles (Van Oosterom &
// Strackee 1983), in float64. No ray is cast, so that neither edges nor thin walls can be missed.
#pragma once

#include <optional>
#include <vector>

#include "equaltime/math/box_tree.h"
#include "equaltime/shapes/geometry.h"

namespace equaltime {

/// What a mesh is to a point.
struct Enclosure {
  bool behind;    // the point is on the side that the triangles' backs are on
  double volume;  // of the inside, not negative
};

/// At a time from 0 to 1, if the mesh deforms. Nothing if it is not closed.
[[nodiscard]] std::optional<Enclosure> enclosure(const TriangleMesh& mesh, const Vec3d& point, float time) noexcept;
[[nodiscard]] Enclosure enclosure(const Sphere<float>& sphere, bool flipped, const Vec3d& point) noexcept;

/// The same for a mesh that is asked about many points. The winding number is counted along a line through the point,
/// by the triangles that the line crosses. Triangles that share an edge agree on which side of it the line passes, so
/// that none is missed; where the crossings along the whole line do not cancel (through a crack, or a mesh that is not
/// closed after all), and for points on the surface, all triangles are looked at.
class ClosedMesh {
 public:
  /// `box` is around the mesh at all times. The mesh must stay where it is.
  ClosedMesh(const TriangleMesh& mesh, const Bounds& box);

  /// To be called before points within the box are asked about.
  void prepare();
  [[nodiscard]] std::optional<Enclosure> enclosure(const Vec3d& point, float time) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return sizeof(*this) + tree_.memory_bytes(); }

 private:
  [[nodiscard]] double volume(float time) const noexcept;
  [[nodiscard]] bool closed_from_outside() const noexcept;
  /// Nothing if the line through the point does not tell.
  [[nodiscard]] std::optional<int> winding(const Vec3d& point, float time) const noexcept;

  const TriangleMesh* mesh_;
  Bounds box_;
  std::vector<double> volumes_;  // signed; three to a part of the shutter, and one at its end
  bool closed_ = true;
  std::size_t axis_ = 2;  // along which lines run
  BoxTree tree_;          // of the triangles
};

}  // namespace equaltime
