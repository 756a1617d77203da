// Meshes and instances, from their description to normalised space. Part of build_scene.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/instance.h"
#include "scene/normalization.h"
#include "scene/texture.h"

namespace equaltime {

/// Throws std::invalid_argument that names the shape.
[[noreturn]] void fail(std::size_t shape, const std::string& what);

/// The mesh in the space, its triangles moved out of the description; checks vertices and the lengths of arrays.
[[nodiscard]] TriangleMesh placed_mesh(std::size_t shape, MeshDescription& mesh, const Normalization& space);
/// Drops triangles without an area, with their attributes, and returns how many; checks that indices are in range.
std::size_t drop_degenerate(std::size_t shape, TriangleMesh& mesh, std::vector<AttributeValues>& attributes);
/// Hands the attributes of a mesh to the textures that look them up.
void add_attributes(std::uint32_t shape, const TriangleMesh& mesh, std::vector<AttributeValues>& attributes,
                    std::vector<Texture>& textures);
/// How the point moves with u on each triangle; without usable uvs, what Frame makes of the normal, as Mitsuba does.
[[nodiscard]] std::vector<Vec3f> triangle_tangents(const TriangleMesh& mesh,
                                                   const std::vector<std::array<double, 2>>& uvs);
[[nodiscard]] std::vector<Point2f> float_uvs(std::size_t shape, const std::vector<std::array<double, 2>>& uvs);
[[nodiscard]] MeshView view_of(const TriangleMesh& mesh, const Surface& surface, std::uint32_t shape) noexcept;

/// Where instances stand, each from the space of its group to normalised space.
[[nodiscard]] std::vector<InstanceGeometry> place_instances(const std::vector<InstanceDescription>& instances,
                                                            const std::vector<Normalization>& groups,
                                                            const Normalization& world);

}  // namespace equaltime
