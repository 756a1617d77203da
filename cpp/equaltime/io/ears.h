// Faces of more than three corners as triangles. A convex face is a fan round its first corner. A concave one is cut by
// ears (Meisters 1975, "Polygons have ears"): triangles of three corners in a row that hold no other corner. Corners
// are looked at in the plane of two axes on which the face is largest, so that a face may be bent a little.
#pragma once

#include <cstdint>
#include <vector>

#include "equaltime/io/mesh_data.h"

namespace equaltime {

/// A face of a file, which stands in a mesh as a fan of consecutive triangles.
struct FannedFace {
  std::uint64_t first;      // its first triangle
  std::uint64_t triangles;  // two fewer than its corners
  std::uint64_t place;      // its line, or its number in the file
};

/// The warning of a face that could not be cut.
inline constexpr const char* kUncutFace = "crosses itself, or has thousands of corners, and stays a fan of triangles";

struct UncutFaces {
  std::uint64_t count = 0, first_place = 0;
};

/// Replaces the fans of concave faces by as many triangles that do not overlap; other fans stay as they are, to the
/// bit. A concave face stays a fan if it crosses itself, or if cutting it would take seconds; returns how many do, and
/// the place of the first.
[[nodiscard]] UncutFaces cut_concave_faces(MeshData& mesh, const std::vector<FannedFace>& faces);

}  // namespace equaltime
