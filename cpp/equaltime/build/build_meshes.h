// Meshes and instances, from their description to normalised space. Part of build_scene.
#pragma once

#include <array>
#include <stdexcept>
#include <string>
#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"
#include "equaltime/scene/deforming_mesh.h"
#include "equaltime/scene/instance.h"
#include "equaltime/shapes/triangle_tangent.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

/// A shape that cannot be built, by its number in the scene: shapes of groups are counted after all others.
class ShapeError : public std::invalid_argument {
 public:
  ShapeError(std::size_t shape, const std::string& problem)
      : std::invalid_argument("shape " + std::to_string(shape) + ": " + problem), shape_(shape), problem_(problem) {}
  [[nodiscard]] std::size_t shape() const noexcept { return shape_; }
  /// The text of the error without the shape.
  [[nodiscard]] const std::string& problem() const noexcept { return problem_; }

 private:
  std::size_t shape_;
  std::string problem_;
};

/// Throws a ShapeError.
[[noreturn]] void fail(std::size_t shape, const std::string& problem);

/// The mesh in the space; the description gives up its vertices and triangles. Checks vertices and the lengths of
/// arrays.
[[nodiscard]] TriangleMesh placed_mesh(std::size_t shape, MeshDescription& mesh, const Normalization& space);
/// Drops triangles without an area, with their attributes, and returns how many; checks that indices are in range.
std::size_t drop_degenerate(std::size_t shape, TriangleMesh& mesh, std::vector<AttributeValues>& attributes);
/// Hands the attributes of a mesh to the textures that look them up.
void add_attributes(std::uint32_t shape, const TriangleMesh& mesh, std::vector<AttributeValues>& attributes,
                    std::vector<Texture>& textures);
/// The tangent of each triangle; by barycentric coordinates if there are no uvs.
[[nodiscard]] std::vector<Vec3f> triangle_tangents(const TriangleMesh& mesh,
                                                   const std::vector<std::array<double, 2>>& uvs);
[[nodiscard]] std::vector<Point2f> float_uvs(std::size_t shape, const std::vector<std::array<double, 2>>& uvs);
/// Views of all meshes, those of groups last; `mesh_shapes` says which shape each is.
[[nodiscard]] std::vector<MeshView> view_meshes(const Accel& accel, const ShapeRange& top,
                                                const std::vector<ShapeRange>& groups,
                                                const std::vector<std::uint32_t>& mesh_shapes,
                                                const std::vector<Surface>& surfaces);

/// Gives a surface the normals of a mesh that deforms, and refuses what that cannot have.
void deform(std::size_t index, const MeshDescription& from, const TriangleMesh& mesh, Surface& surface);
/// One a mesh, or none at all if no mesh deforms.
[[nodiscard]] std::vector<std::optional<DeformingMesh>> deforming_meshes(const Accel& accel,
                                                                         const std::vector<MeshView>& views,
                                                                         const std::vector<ShapeRange>& groups,
                                                                         const std::vector<Surface>& surfaces);

/// Where instances stand, each from the space of its group to normalised space.
[[nodiscard]] std::vector<InstanceGeometry> place_instances(const std::vector<InstanceDescription>& instances,
                                                            const std::vector<Normalization>& groups,
                                                            const Normalization& world);
/// Which shape is the instance of each group, if it has only one.
[[nodiscard]] std::vector<std::optional<std::size_t>> only_instances(const std::vector<ShapeDescription>& shapes,
                                                                     std::size_t groups);
/// Where azimuth is counted from, and which way round.
void set_azimuth(Surface& surface, const Vec3d& axis, const Vec3d& meridian, bool mirrored) noexcept;
[[nodiscard]] std::vector<MovingInstanceGeometry> move_instances(const std::vector<InstanceDescription>& instances,
                                                                 const std::vector<Normalization>& groups,
                                                                 const Normalization& world);

}  // namespace equaltime
