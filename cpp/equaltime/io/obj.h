// Reads Wavefront OBJ: v, vt, vn, and f with polygons (concave ones are cut by ears) and negative indices. Corners with
// the same v/vt/vn become one vertex, in the order of their first use. Colours after the numbers of v become the
// attribute vertex_color. The reader gives the names of materials and of their libraries; it does not open these.
// obj_words.h lists the other statements and what becomes of them; what is not used is told.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "equaltime/io/mesh_data.h"

namespace equaltime {

// Throws MeshError with the line. Where only some corners of a file have a vt, the others get uv (0, 0); where only
// some have a vn, the others get the normal of the faces around them: a warning counts either. A face may come before
// its vertices. If `material` is given, only its faces are read: those after a usemtl of that name, or, for "", those
// before any.
[[nodiscard]] MeshData read_obj(const std::filesystem::path& path, const std::optional<std::string>& material = {});

struct ObjMaterial {
  std::string name;  // bytes of the file, in whatever encoding
  MeshData mesh;
};

// The meshes of all materials that have faces, in the order of their first faces, each as read_obj gives it; the file
// is read once. Throws MeshError if one of them is wrong, or if there is none.
[[nodiscard]] std::vector<ObjMaterial> read_obj_by_material(const std::filesystem::path& path);

// The name in the rest of a statement such as usemtl: without blanks around it and without a comment. A # is part of
// the name within a word, in a word that begins the name, and before a number that ends it, as in the "Material #25" of
// 3ds Max.
[[nodiscard]] std::string_view obj_name(std::string_view rest) noexcept;

}  // namespace equaltime
