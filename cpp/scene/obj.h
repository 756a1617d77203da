// Wavefront OBJ: v, vt, vn and f with polygons (fans round their first corner) and negative indices. Corners with the
// same v/vt/vn become one vertex, in the order of their first use. Groups, objects, smoothing groups and vertex colours
// are ignored; so are lines, points and curves, with one warning that counts them. Of materials there are the names.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "scene/mesh_data.h"

namespace equaltime {

// Throws MeshError with the line. A corner without vt gets uv (0, 0), one without vn the normal of the faces around it,
// each with a counted warning, if other corners of the file have them. A face may come before its vertices. With a
// material, only the faces that are of it are read: those after a usemtl of that name, or "" for those before any.
[[nodiscard]] MeshData read_obj(const std::filesystem::path& path, const std::optional<std::string>& material = {});

// The meshes of all materials that have faces, by their names, as read_obj gives each; the file is read once.
[[nodiscard]] std::map<std::string, MeshData> read_obj_by_material(const std::filesystem::path& path);

}  // namespace equaltime
