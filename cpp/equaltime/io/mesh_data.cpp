#include "equaltime/io/mesh_data.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace equaltime {
namespace {

using Vec = std::array<double, 3>;

Vec vertex(const MeshData& mesh, std::uint32_t i) {
  const double* p = mesh.vertices.data() + 3 * std::size_t{i};
  return {p[0], p[1], p[2]};
}

bool finite(const Vec& v) { return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]); }
bool zero(const Vec& v) { return v[0] == 0 && v[1] == 0 && v[2] == 0; }
Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double largest(const Vec& v) { return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}); }
Vec times(const Vec& v, double s) { return {v[0] * s, v[1] * s, v[2] * s}; }

// Twice the area times the normal, by the winding of the corners; edges are brought near 1 only where the plain product
// is zero or not finite, which is rare: tiny or huge meshes.
Vec area_vector(const Vec& a, const Vec& b, const Vec& c) {
  const Vec e = minus(b, a), f = minus(c, a);
  const Vec n = cross(e, f);
  if (finite(n) && !zero(n)) return n;
  if (zero(e) || zero(f)) return {0, 0, 0};
  return cross(times(e, 1 / largest(e)), times(f, 1 / largest(f)));
}

void move_face(std::vector<MeshAttributeData>& attributes, std::size_t from, std::size_t to) {
  for (MeshAttributeData& a : attributes) {
    if (a.per_face) std::copy_n(a.values.data() + from * a.width, a.width, a.values.data() + to * a.width);
  }
}

// Keeps the faces that have an area, in order, and marks the vertices that they use. Returns how many were dropped.
std::uint64_t keep_real_faces(MeshData& mesh, std::vector<bool>& used, const VertexPlace& place) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i + 2 < mesh.faces.size(); i += 3) {
    const std::uint32_t face[3] = {mesh.faces[i], mesh.faces[i + 1], mesh.faces[i + 2]};
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    const Vec corners[3] = {vertex(mesh, face[0]), vertex(mesh, face[1]), vertex(mesh, face[2])};
    const Vec n = area_vector(corners[0], corners[1], corners[2]);
    if (zero(n)) continue;
    move_face(mesh.attributes, i / 3, kept / 3);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!finite(n) && !finite(corners[k])) throw MeshError(place(face[k]) + " is not finite and a face uses it");
      used[face[k]] = true;
      mesh.faces[kept++] = face[k];
    }
  }
  const std::uint64_t dropped = (mesh.faces.size() - kept) / 3;
  mesh.faces.resize(kept);
  for (MeshAttributeData& a : mesh.attributes) {
    if (a.per_face) a.values.resize(kept / 3 * a.width);
  }
  return dropped;
}

void keep_rows(std::vector<double>& rows, std::size_t width, const std::vector<bool>& used) {
  if (rows.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    for (std::size_t k = 0; k < width; ++k) rows[kept * width + k] = rows[i * width + k];
    ++kept;
  }
  rows.resize(kept * width);
}

void drop_unused_vertices(MeshData& mesh, const std::vector<bool>& used) {
  if (std::find(used.begin(), used.end(), false) == used.end()) return;
  std::vector<std::uint32_t> renumbered(used.size());
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < used.size(); ++i) {
    renumbered[i] = next;
    next += used[i] ? 1 : 0;
  }
  for (std::uint32_t& index : mesh.faces) index = renumbered[index];
  keep_rows(mesh.vertices, 3, used);
  keep_rows(mesh.normals, 3, used);
  keep_rows(mesh.uvs, 2, used);
  for (MeshAttributeData& a : mesh.attributes) {
    if (!a.per_face) keep_rows(a.values, a.width, used);
  }
}

std::size_t repair_normals(MeshData& mesh) {
  std::vector<bool> bad(mesh.normals.size() / 3);
  std::size_t count = 0;
  for (std::size_t i = 0; i < bad.size(); ++i) {
    double* n = mesh.normals.data() + 3 * i;
    const Vec normal = {n[0], n[1], n[2]};
    if (finite(normal) && !zero(normal)) continue;
    bad[i] = true, ++count;
    std::fill_n(n, 3, 0.0);
  }
  for (std::size_t i = 0; count > 0 && i < mesh.faces.size(); i += 3) {
    const std::uint32_t* face = mesh.faces.data() + i;
    if (!bad[face[0]] && !bad[face[1]] && !bad[face[2]]) continue;
    const Vec n = area_vector(vertex(mesh, face[0]), vertex(mesh, face[1]), vertex(mesh, face[2]));
    for (std::size_t k = 0; k < 3; ++k) {
      if (!bad[face[k]]) continue;
      double* sum = mesh.normals.data() + 3 * std::size_t{face[k]};
      const Vec next = {sum[0] + n[0], sum[1] + n[1], sum[2] + n[2]};
      // Two faces back to back cancel: the first one's normal is kept then.
      if (finite(next) && !zero(next)) std::copy(next.begin(), next.end(), sum);
    }
  }
  return count;
}

std::size_t repair_uvs(MeshData& mesh) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < mesh.uvs.size(); i += 2) {
    if (std::isfinite(mesh.uvs[i]) && std::isfinite(mesh.uvs[i + 1])) continue;
    mesh.uvs[i] = mesh.uvs[i + 1] = 0, ++count;
  }
  return count;
}

std::size_t repair_attribute(MeshAttributeData& attribute) {
  std::size_t count = 0;
  for (double& value : attribute.values) {
    if (!std::isfinite(static_cast<float>(value))) value = 0, ++count;
  }
  return count;
}

std::string counted(std::uint64_t n, const std::string& noun, const std::string& plural) {
  return std::to_string(n) + " " + (n == 1 ? noun : plural);
}

}  // namespace

void finish_mesh(MeshData& mesh, const std::filesystem::path& path, std::uint64_t dropped, const VertexPlace& place) {
  const auto warn = [&](const std::string& text) { mesh.warnings.push_back(text); };
  std::vector<bool> used(mesh.vertices.size() / 3);
  dropped += keep_real_faces(mesh, used, place);
  if (mesh.faces.empty() && dropped == 0) throw MeshError(path.string() + ": the mesh is empty: it has no faces", true);
  if (mesh.faces.empty()) {
    const std::string count = std::to_string(dropped);
    throw MeshError(path.string() + ": the mesh is empty: all its faces are degenerate (" + count +
                        ", repeated corners or no area)",
                    true);
  }
  drop_unused_vertices(mesh, used);
  if (dropped > 0) {
    warn(counted(dropped, "degenerate face was", "degenerate faces were") + " dropped (repeated corners or no area)");
  }
  if (const std::size_t n = repair_normals(mesh)) {
    warn(counted(n, "vertex has no usable normal and got that", "vertices have no usable normal and got those") +
         " of the faces around it");
  }
  if (const std::size_t n = repair_uvs(mesh)) {
    warn(counted(n, "vertex has no usable uv and got", "vertices have no usable uv and got") + " (0, 0)");
  }
  for (MeshAttributeData& a : mesh.attributes) {
    if (const std::size_t n = repair_attribute(a))
      warn(counted(n, "number", "numbers") + " of " + a.name + " not finite in single precision became 0");
  }
}

}  // namespace equaltime
