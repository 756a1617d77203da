// What the fuzzers of mesh readers share: an input as a file, a limit of memory, and the promises of io/mesh_data.h,
// which every mesh that is read must keep.
#pragma once

#include <sanitizer/allocator_interface.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "equaltime/io/mesh_data.h"

namespace equaltime {

/// A file in memory that holds one input after the other.
class InputFile {
 public:
  InputFile() : number_(memfd_create("input", 0)) {}
  ~InputFile() { close(number_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::filesystem::path hold(const std::uint8_t* data, std::size_t size) const {
    if (ftruncate(number_, 0) != 0 || pwrite(number_, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
    return "/proc/self/fd/" + std::to_string(number_);
  }

 private:
  int number_;
};

inline void require(bool kept, const char* promise) {
  if (kept) return;
  std::fprintf(stderr, "a promise is broken: %s\n", promise);
  std::abort();
}

inline void require_promises(const MeshData& mesh) {
  const std::size_t count = mesh.vertices.size() / 3;
  require(mesh.vertices.size() == 3 * count && !mesh.faces.empty() && mesh.faces.size() % 3 == 0,
          "a mesh of triangles");
  for (const double x : mesh.vertices) require(std::isfinite(x), "vertices are finite");
  for (const std::uint32_t index : mesh.faces) require(index < count, "indices are in range");
  require(mesh.normals.empty() || mesh.normals.size() == 3 * count, "a normal for each vertex");
  for (const double x : mesh.normals) require(std::isfinite(x), "normals are finite");
  require(mesh.uvs.empty() || mesh.uvs.size() == 2 * count, "a uv for each vertex");
  for (const double x : mesh.uvs) require(std::isfinite(x), "uvs are finite");
  for (const MeshAttributeData& a : mesh.attributes) {
    require(a.values.size() == a.width * (a.per_face ? mesh.faces.size() / 3 : count), "attributes for each");
    for (const double x : a.values) require(std::isfinite(x), "attributes are finite");
  }
}

/// Bytes that a reader may hold at once: 64 MiB and 20 times its input.
inline std::size_t limit_of(std::size_t input) { return (std::size_t{64} << 20) + 20 * input; }

inline std::size_t& allowed_bytes() {
  static std::size_t bytes = ~std::size_t{0};
  return bytes;
}
inline void watch_allocation(const volatile void*, std::size_t) {
  if (__sanitizer_get_current_allocated_bytes() <= allowed_bytes()) return;
  std::fprintf(stderr, "more memory than 64 MiB and 20 times the input\n");
  std::abort();
}

/// Reads one input: it is a mesh that keeps the promises, or it is refused.
template <class Read>
int fuzz_reader(const std::uint8_t* data, std::size_t size, Read&& read) {
  static const InputFile file;
  static const int watching = __sanitizer_install_malloc_and_free_hooks(watch_allocation, [](const volatile void*) {});
  require(watching != 0, "allocations are watched");
  const std::filesystem::path path = file.hold(data, size);
  allowed_bytes() = __sanitizer_get_current_allocated_bytes() + limit_of(size);
  try {
    require_promises(read(path));
  } catch (const MeshError& refused) {
    require(std::string(refused.what()).starts_with(path.string()), "an error begins with its place");
  }
  allowed_bytes() = ~std::size_t{0};
  return 0;
}

}  // namespace equaltime
