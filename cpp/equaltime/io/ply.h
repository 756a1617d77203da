// Stanford PLY: ascii, little and big endian, any scalar type. Elements `vertex` (x y z; nx ny nz; u v, s t or
// texture_u texture_v) and `face` (vertex_indices or vertex_index, polygons of which the concave ones are cut by ears;
// texcoord, the uvs of its corners), the attributes of ply_columns.h, and the names of images in comments. The rest is
// told.
#pragma once

#include <filesystem>

#include "equaltime/io/mesh_data.h"

namespace equaltime {

// Throws MeshError, with a line for ascii files and a byte offset for binary ones. Memory is taken only for what the
// size of the file can hold.
[[nodiscard]] MeshData read_ply(const std::filesystem::path& path);

}  // namespace equaltime
