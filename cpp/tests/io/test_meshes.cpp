// The PLY and OBJ readers on small files written here: what is read, what is repaired, what is refused and where.
#include <unistd.h>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>

#include "equaltime/io/obj.h"
#include "equaltime/io/ply.h"
#include "tests/check.h"

namespace {

using equaltime::MeshData;
using equaltime::MeshError;
using Doubles = std::vector<double>;
using Indices = std::vector<std::uint32_t>;

// A file with the given content; gone when the test is over.
class File {
 public:
  explicit File(const std::string& content, const std::string& suffix)
      : path_(std::filesystem::temp_directory_path() / ("equaltime_mesh_" + std::to_string(getpid()) + suffix)) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~File() { std::filesystem::remove(path_); }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

MeshData obj(const std::string& content) { return equaltime::read_obj(File(content, ".obj").path()); }
MeshData ply(const std::string& content) { return equaltime::read_ply(File(content, ".ply").path()); }

std::string header(const std::string& format, const std::string& vertices, const std::string& faces) {
  return "ply\nformat " + format + " 1.0\ncomment made here\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}
const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";

template <typename T>
std::string bytes(T value, bool big = false) {
  std::string out(sizeof(T), '\0');
  std::memcpy(out.data(), &value, sizeof(T));
  return big ? std::string(out.rbegin(), out.rend()) : out;
}
std::string triangle(bool big, std::int32_t last) {
  std::string out;
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.5f, 0.f}) out += bytes(x, big);
  out += '\3';
  for (const std::int32_t i : {0, 1, last}) out += bytes(i, big);
  return out;
}

TEST("an OBJ triangle is read in float64") {
  const MeshData mesh = obj("v 0.1 0 0\nv +1e0 0 1e-400\nv 0 1 0\nf 1 2 3\n");
  CHECK((mesh.vertices == Doubles{0.1, 0, 0, 1, 0, 0, 0, 1, 0}));
  CHECK((mesh.faces == Indices{0, 1, 2}));
  CHECK(mesh.normals.empty() && mesh.uvs.empty() && mesh.warnings.empty());
}

TEST("corners with the same v, vt and vn share a vertex, others do not") {
  const MeshData mesh =
      obj(kCorners + "vt 0 0\nvt 1 0.5\nvn 0 0 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/1/1\nf 2/2/1 4/1/1 3/1/2\n");
  CHECK((mesh.faces == Indices{0, 1, 2, 1, 3, 4}));
  CHECK((mesh.uvs == Doubles{0, 0, 1, 0.5, 0, 0, 0, 0, 0, 0}));
  CHECK((mesh.normals == Doubles{0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 2}));
}

TEST("polygons become fans, negative indices count back from their line") {
  CHECK((obj(kCorners + "f 1 2 4 3\n").faces == Indices{0, 1, 2, 0, 2, 3}));
  const MeshData mesh = obj("v 9 9 9\n" + kCorners + "f -4 -3 -2\nv 5 5 5\n");
  CHECK((mesh.vertices == Doubles{0, 0, 0, 1, 0, 0, 0, 1, 0}));
}

TEST("a face may come before its vertices, in any kind of line ends, with comments and continued lines") {
  const Indices one = {0, 1, 2};
  CHECK(obj("f 1 2 3\n" + kCorners).faces == one);
  CHECK(obj("v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n").faces == one);
  CHECK(obj("v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3").faces == one);
  CHECK(obj("\xef\xbb\xbf" + kCorners + "f 1 \\\n 2 3 # the end\n").faces == one);
}

TEST("names are silent, statements that are not read are told, one line a kind") {
  CHECK(obj("mtllib a.mtl\ng a f b\nusemtl c\ns 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").warnings.empty());
  const MeshData mesh = obj(kCorners + "l 1 2\np 3\nl 2 3\nfoo\nf 1 2 3\n");
  CHECK((mesh.warnings == std::vector<std::string>{"line 5: 'l' is not rendered: a line has no surface (first of 2)",
                                                   "line 6: 'p' is not rendered: a point has no surface",
                                                   "line 8: 'foo' is no statement of OBJ that is read"}));
}

TEST("a corner without a normal gets that of its faces, one without uv gets 0, each with a warning") {
  const MeshData mesh = obj(kCorners + "vn 0 0 1\nvn nan 0 0\nvt 2 2\nf 1/1/1 2/1/2 3/1\nf 2//1 4//1 3//1\n");
  CHECK(mesh.warnings.size() == 2);
  for (std::size_t i = 0; i < mesh.normals.size(); ++i) CHECK(mesh.normals[i] == (i % 3 == 2 ? 1 : 0));
  CHECK((Doubles(mesh.uvs.end() - 6, mesh.uvs.end()) == Doubles(6, 0.0)));
}

TEST("degenerate faces are dropped, counted and reported once, and their vertices with them") {
  const MeshData mesh = obj(kCorners + "v 2 0 0\nf 1 2 3\nf 1 1 2\nf 1 2 5\nf 1 2\n");
  CHECK(mesh.faces.size() == 3 && mesh.vertices.size() == 9);
  CHECK(mesh.warnings.size() == 1 && mesh.warnings[0].find("3 degenerate faces") != std::string::npos);
  CHECK_THROWS(MeshError, "all its faces are degenerate (2", obj(kCorners + "f 1 1 2\nf 2 2 2\n"));
}

TEST("a triangle too small for its area in float64 is not degenerate") {
  CHECK(obj("v 0 0 0\nv 1e-200 0 0\nv 0 1e-200 0\nf 1 2 3\n").faces.size() == 3);
}

TEST("a vertex that is not finite is an error with its line, unless no face uses it") {
  CHECK_THROWS(MeshError, ".obj:3: vertex 3 is not finite", obj("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"));
  CHECK_THROWS(MeshError, ".obj:2: vertex 2 is not finite", obj("v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n"));
  CHECK(obj("v nan 0 0\n" + kCorners + "f 2 3 4\n").vertices.size() == 9);
}

TEST("what is wrong in an OBJ is said with its line") {
  CHECK_THROWS(MeshError, ".obj:5: vertex 7 does not exist: the file has 4", obj(kCorners + "f 1 2 7\n"));
  CHECK_THROWS(MeshError, ".obj:5: vertex -5 does not exist: 4 before this line", obj(kCorners + "f 1 2 -5\n"));
  CHECK_THROWS(MeshError, ".obj:5: vertex 0 does not exist", obj(kCorners + "f 0 1 2\n"));
  CHECK_THROWS(MeshError, ".obj:5: vt 1 does not exist", obj(kCorners + "f 1/1 2/1 3/1\n"));
  CHECK_THROWS(MeshError, ".obj:1: expected a number, found '1,5'", obj("v 0 0 1,5\n"));
  CHECK_THROWS(MeshError, ".obj:1: expected a number, found the end of the line", obj("v 0 0\n"));
  CHECK_THROWS(MeshError, ".obj:5: expected a corner", obj(kCorners + "f 1 2 3/1/1/1\n"));
  CHECK_THROWS(MeshError, ".obj:5: expected a corner", obj(kCorners + "f 1 2 99999999999999999999\n"));
  CHECK_THROWS(MeshError, "the mesh is empty: it has no faces", obj(kCorners));
  CHECK_THROWS(MeshError, "no such file", equaltime::read_obj("/nonexistent/a.obj"));
  CHECK_THROWS(MeshError, "not a regular file", equaltime::read_obj("/dev/zero"));
}

TEST("an ascii PLY is read with normals and uvs by any of their names, other properties and elements skipped") {
  const std::string names[4][2] = {{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
  for (const auto& uv : names) {
    const MeshData mesh =
        ply("ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement other 1\r\nproperty list uchar float a\r\nelement vertex "
            "3\r\n"
            "property double x\r\nproperty uchar red\r\nproperty double y\r\nproperty double z\r\nproperty float nx\r\n"
            "property float ny\r\nproperty float nz\r\nproperty float " +
            uv[0] + "\r\nproperty float " + uv[1] +
            "\r\nelement face 1\r\nproperty char kind\r\nproperty list uchar uint vertex_index\r\nend_header\r\n"
            "2 7 8\r\n0.1 255 0 0 0 0 1 .25 .5\r\n\r\n1 0 0 0 0 0 1 1 0\r\n0 0 1 0 0 0 1 0 1\r\n-1 3 0 1 2\r\n");
    CHECK((mesh.vertices == Doubles{0.1, 0, 0, 1, 0, 0, 0, 1, 0}));
    CHECK((mesh.normals == Doubles{0, 0, 1, 0, 0, 1, 0, 0, 1}));
    CHECK((mesh.uvs == Doubles{.25, .5, 1, 0, 0, 1}));
    CHECK((mesh.faces == Indices{0, 1, 2}));
  }
}

TEST("a binary PLY is read in either byte order, and faces may stand before vertices") {
  CHECK((ply(header("binary_little_endian", "3", "1") + triangle(false, 2)).vertices[7] == 1.5));
  CHECK((ply(header("binary_big_endian", "3", "1") + triangle(true, 2)).vertices[7] == 1.5));
  std::string swapped =
      "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uchar uchar vertex_index\n";
  swapped +=
      "element vertex 3\nproperty list int double a\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n";
  swapped += std::string("\3\0\1\2", 4);
  for (const float x : {0.f, 1.f, 2.f}) {
    swapped += bytes<std::int32_t>(1) + bytes(7.0) + bytes(x) + bytes(x * x) + bytes(0.f);
  }
  CHECK((ply(swapped).vertices == Doubles{0, 0, 0, 1, 1, 0, 2, 4, 0}));
}

TEST("a binary PLY that is cut anywhere is an error, whatever it declares") {
  const std::string whole = header("binary_little_endian", "3", "1") + triangle(false, 2);
  for (std::size_t size = 0; size < whole.size(); ++size) CHECK_THROWS(MeshError, ".ply", ply(whole.substr(0, size)));
  for (const std::string count : {"4", "4000000000", "9000000000000000000"}) {
    CHECK_THROWS(MeshError, ".ply", ply(header("binary_little_endian", count, "1") + triangle(false, 2)));
    CHECK_THROWS(MeshError, ".ply", ply(header("binary_little_endian", "3", count) + triangle(false, 2)));
    CHECK_THROWS(MeshError, ".ply", ply(header("ascii", count, "1") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  }
}

TEST("what is wrong in a PLY is said with its line or its byte offset") {
  const std::string ascii = header("ascii", "3", "1"), corners = "0 0 0\n1 0 0\n0 1 0\n";
  const std::string binary = header("binary_little_endian", "3", "1");
  const std::string face_at = "byte offset " + std::to_string(binary.size() + 9 * sizeof(float) + 1) + ": ";
  CHECK_THROWS(MeshError, face_at + "face with vertex index 3: the file has the vertices 0 to 2",
               ply(binary + triangle(false, 3)));
  CHECK_THROWS(MeshError, face_at + "face with vertex index -1", ply(binary + triangle(false, -1)));
  CHECK_THROWS(MeshError, ".ply:14: face with vertex index 3", ply(ascii + corners + "3 0 1 3\n"));
  CHECK_THROWS(MeshError, ".ply:12: expected a number for 'z', found the end of the line", ply(ascii + "0 0 0\n1 0\n"));
  CHECK_THROWS(MeshError, ".ply:13: the file ends before element 2 of 3 'vertex'",
               ply(ascii + "0 0 0\n\n1 0 0      \n"));
  CHECK_THROWS(MeshError, ".ply:11: more values than properties", ply(ascii + "0 0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
  CHECK_THROWS(MeshError, ".ply:12: vertex 1 (counted from 0) is not finite",
               ply(ascii + "0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n"));
  CHECK_THROWS(MeshError, ".ply:1: not a PLY file", ply("solid"));
  CHECK_THROWS(MeshError, ".ply: not a PLY file: it is empty", ply(""));
  CHECK_THROWS(MeshError, ".ply:2: expected format", ply("ply\nformat binary 1.0\n"));
  CHECK_THROWS(MeshError, ".ply:4: expected a PLY type",
               ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n"));
  CHECK_THROWS(MeshError, "the file has no faces", ply(header("ascii", "3", "0") + corners));
  CHECK_THROWS(MeshError, "no property 'z'",
               ply("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
                   "element face 1\nproperty list uchar int vertex_indices\nend_header\n"));
}

TEST("a NaN vertex of a binary PLY is an error with its byte offset") {
  const std::string head = header("binary_little_endian", "3", "1");
  std::string body = triangle(false, 2);
  body.replace(12, 4, bytes(std::numeric_limits<float>::quiet_NaN()));
  CHECK_THROWS(MeshError,
               "byte offset " + std::to_string(head.size() + 12) + ": vertex 1 (counted from 0) is not finite",
               ply(head + body));
}

TEST("files with changed bytes are read or refused, and never anything else") {
  std::mt19937 random(7);
  const std::string seeds[] = {header("binary_big_endian", "3", "1") + triangle(true, 2),
                               header("ascii", "3", "1") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"};
  const std::string text = kCorners + "vt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\nf -1//-1 -2 -3/1\n";
  for (int i = 0; i < 3000; ++i) {
    std::string content = i % 3 < 2 ? seeds[i % 3] : text;
    for (int k = 0; k < 1 + i % 4; ++k) content[random() % content.size()] = static_cast<char>(random() % 256);
    try {
      const MeshData mesh = i % 3 < 2 ? ply(content) : obj(content);
      for (const std::uint32_t index : mesh.faces) CHECK(3 * std::size_t{index} + 2 < mesh.vertices.size());
      for (const double x : mesh.vertices) CHECK(std::isfinite(x));
    } catch (const MeshError&) {
    }
  }
}

}  // namespace

int main() { return check::run(); }
