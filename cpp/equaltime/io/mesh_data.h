// A triangle mesh as a file gives it: flat float64 arrays in the file's own space and units, before any transform.
// Readers promise: every vertex is finite and used by a face, every face has three different vertices and an area
// that is not zero in float64, every index is in range. Normals are as the file has them, not normalised.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace equaltime {

// Further numbers of each vertex or face, by Mitsuba's name for them, such as "vertex_color"; finite.
struct MeshAttributeData {
  std::string name;
  std::size_t width = 3;  // numbers a vertex or a face
  bool per_face = false;
  std::vector<double> values;
  double full = 1;  // what stands for 1: the largest value of the file's type if it holds whole numbers
};

// A file that a mesh file names for how it looks: a library of materials, or an image.
struct NamedFile {
  std::string name;  // bytes of the file, in whatever encoding
  std::uint64_t line = 0;
};

struct MeshData {
  std::vector<double> vertices;      // 3 N
  std::vector<std::uint32_t> faces;  // 3 M, indices into the N vertices
  std::vector<double> normals;       // 3 N, or empty
  std::vector<double> uvs;           // 2 N, or empty
  std::vector<MeshAttributeData> attributes;
  std::vector<NamedFile> files;       // those that the file names; nothing is looked for
  std::vector<std::string> warnings;  // what was repaired, dropped or is not used, counted; without the path
};

// A mesh file that cannot be read. The text starts with the place: "path:line: ", "path: byte offset N: " or "path: ".
class MeshError : public std::runtime_error {
 public:
  explicit MeshError(const std::string& text, bool no_face_left = false)
      : std::runtime_error(text), no_face_left_(no_face_left) {}
  [[nodiscard]] bool no_face_left() const noexcept { return no_face_left_; }

 private:
  bool no_face_left_;
};

// Says where vertex i of a mesh stands in its file, and which one it is, for an error: "path:12: vertex 3".
using VertexPlace = std::function<std::string(std::uint32_t)>;

// Brings a mesh whose indices are all in range to the promises above: drops degenerate triangles and unused vertices,
// replaces normals that are missing (NaN), infinite or zero by those of the triangles around them, and uvs and
// attributes that are not finite by 0. `dropped` counts the faces with fewer than three corners that the reader left
// out already. Throws MeshError if nothing is left or a face uses a vertex that is not finite.
void finish_mesh(MeshData& mesh, const std::filesystem::path& path, std::uint64_t dropped, const VertexPlace& place);

}  // namespace equaltime
