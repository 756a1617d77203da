// Ranks the dielectrics that overlap, and finds what holds the camera.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/scene/nesting.h"

namespace equaltime {

class CameraMotion;
struct Geometries;
struct Material;
struct MovingInstanceGeometry;
struct ShapeRange;

/// The shapes of a scene while it is built.
struct ShapesToNest {
  const std::vector<Material>& materials;
  const Geometries& top;
  const std::vector<Geometries>& groups;
  const std::vector<Instance>& instances;
  const std::vector<MovingInstanceGeometry>& moving;
  const std::optional<CameraMotion>& camera_motion;
  const ShapeRange& top_set;
  const std::vector<ShapeRange>& group_sets;
  const std::vector<std::optional<std::size_t>>& only_instances;  // of each group
  const std::vector<std::uint32_t>& mesh_shapes;
  const std::array<std::vector<std::uint32_t>, AnalyticShapes::size>& analytic_shapes;
};

/// Gives a rank to each surface whose shape has a priority and touches another such shape, and finds what holds the
/// camera. `camera` is its position if it does not move. Throws std::invalid_argument, with the shape's name, if a
/// shape cannot have a priority.
[[nodiscard]] Nesting make_nesting(const SceneDescription& description, const ShapesToNest& shapes, const Vec3d& camera,
                                   std::uint32_t camera_medium, std::vector<Surface>& surfaces);

}  // namespace equaltime
