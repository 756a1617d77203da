// Arrays that a reader in Python fills (of .serialized and glTF), whose indices are in range: any numbers, any faces.
#include <algorithm>
#include <cstring>
#include <vector>

#include "tests/fuzz/fuzz_mesh.h"

namespace {

using namespace equaltime;

/// Takes an input apart, from its front; what is missing is 0.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}

  template <class T>
  T take() {
    T value{};
    const std::size_t count = std::min(left_, sizeof(T));
    std::memcpy(&value, data_, count);
    data_ += count, left_ -= count;
    return value;
  }
  /// Numbers as single precision has them, or all bits of double precision.
  std::vector<double> numbers(std::size_t count, bool wide) {
    std::vector<double> values(count);
    for (double& x : values) x = wide ? take<double>() : static_cast<double>(take<float>());
    return values;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

MeshData mesh_of(Bytes bytes) {
  const auto flags = bytes.take<std::uint8_t>();
  const std::size_t vertices = 1 + bytes.take<std::uint8_t>() % 32, faces = bytes.take<std::uint8_t>() % 64;
  const bool wide = (flags & 1) != 0;
  MeshData mesh;
  for (std::size_t i = 0; i < 3 * faces; ++i)
    mesh.faces.push_back(static_cast<std::uint32_t>(bytes.take<std::uint8_t>() % vertices));
  mesh.vertices = bytes.numbers(3 * vertices, wide);
  if ((flags & 2) != 0) mesh.normals = bytes.numbers(3 * vertices, wide);
  if ((flags & 4) != 0) mesh.uvs = bytes.numbers(2 * vertices, wide);
  if ((flags & 8) != 0) mesh.attributes.push_back({"vertex_color", 3, false, bytes.numbers(3 * vertices, wide)});
  if ((flags & 16) != 0) mesh.attributes.push_back({"face_number", 1, true, bytes.numbers(faces, wide)});
  return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return fuzz_reader(data, size, [&](const auto& path) {
    MeshData mesh = mesh_of({data, size});
    finish_mesh(mesh, path, 0, [&](std::uint32_t i) { return path.string() + ": vertex " + std::to_string(i); });
    return mesh;
  });
}
