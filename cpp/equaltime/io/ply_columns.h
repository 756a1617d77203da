// Which numbers of a PLY file's vertices and faces go where in a mesh.
//
// Attributes have the names that Mitsuba 3 gives them: r, g, b or red, green, blue (and alpha, which is not kept), and
// diffuse_red, diffuse_green, diffuse_blue, which Mitsuba does not know, are "color"; consecutive p_r, p_g, p_b are
// "p_color"; p_x, p_y, p_z and p_0, p_1, p_2 are "p"; a lone p_0, p_x or p_r is an attribute of one number; before all
// that stands "vertex_" or "face_". What has no such name is not read.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "equaltime/io/mesh_data.h"
#include "equaltime/io/ply_header.h"

namespace equaltime {

/// One number of each vertex or face: which property it is, and where its values go.
struct PlyColumn {
  std::size_t property, byte;  // its place in the element, and in a binary record without lists
  PlyType type;
  double* first;
  std::size_t stride;
  double factor = 1;  // brings colours of several types to one
};

struct PlyAttribute {
  std::string name;                     // without "vertex_" or "face_"
  std::vector<std::size_t> properties;  // one or three, by their places in the element
};

namespace detail {

/// Scalars of consecutive places, from `first` on, that are `prefix` and one of the endings in order.
inline std::vector<std::size_t> ply_run(const PlyElement& element, std::size_t first, std::string_view prefix,
                                        const std::vector<std::string_view>& endings) {
  std::vector<std::size_t> run;
  for (const std::string_view ending : endings) {
    const std::size_t at = first + run.size();
    if (at >= element.properties.size() || element.properties[at].list_count) break;
    if (element.properties[at].name != std::string(prefix) + std::string(ending)) break;
    run.push_back(at);
  }
  return run;
}

inline void add_ply_colors(const PlyElement& element, std::vector<PlyAttribute>& found) {
  for (const auto& names : {std::array{"r", "g", "b"}, std::array{"red", "green", "blue"},
                            std::array{"diffuse_red", "diffuse_green", "diffuse_blue"}}) {
    std::vector<std::size_t> places;
    for (const char* name : names) {
      const auto at = element.find(name);
      if (at && !element.properties[*at].list_count) places.push_back(*at);
    }
    if (places.size() == 3) return found.push_back({"color", places});
  }
}

}  // namespace detail

[[nodiscard]] inline std::vector<PlyAttribute> ply_attributes(const PlyElement& element) {
  std::vector<PlyAttribute> found;
  detail::add_ply_colors(element, found);
  const std::vector<std::string_view> kinds[] = {{"r", "g", "b", "a"}, {"x", "y", "z", "w"}, {"0", "1", "2", "3"}};
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const std::string& name = element.properties[i].name;
    const std::size_t bar = name.rfind('_');
    if (bar == std::string::npos || bar == 0) continue;
    const std::string prefix = name.substr(0, bar);
    for (const auto& endings : kinds) {
      std::vector<std::size_t> run = detail::ply_run(element, i, prefix + "_", endings);
      if (run.empty()) continue;
      i += run.size() - 1;
      const bool color = endings[0] == "r";
      if (color && run.size() == 4) run.pop_back();
      const std::string full = color ? prefix + "_color" : prefix;
      const bool taken = std::any_of(found.begin(), found.end(), [&](const PlyAttribute& a) { return a.name == full; });
      if ((run.size() == 1 || run.size() == 3) && !taken) found.push_back({full, run});
      break;
    }
  }
  return found;
}

namespace detail {

inline void add_ply_columns(std::vector<PlyColumn>& columns, const PlyElement& element,
                            const std::vector<std::size_t>& properties, double* first, std::size_t stride) {
  for (std::size_t k = 0; k < properties.size(); ++k) {
    std::size_t byte = 0;
    for (std::size_t i = 0; i < properties[k]; ++i) byte += size_of(element.properties[i].type);
    columns.push_back({properties[k], byte, element.properties[properties[k]].type, first + k, stride});
  }
}

/// If the element has them all, the values get room for `count` of each.
inline void add_ply_columns(std::vector<PlyColumn>& columns, const PlyElement& element, std::vector<double>& values,
                            const std::vector<const char*>& names) {
  std::vector<std::size_t> properties;
  for (const char* name : names) {
    const auto at = element.find(name);
    if (!at || element.properties[*at].list_count) return;
    properties.push_back(*at);
  }
  values.resize(names.size() * static_cast<std::size_t>(element.count));
  add_ply_columns(columns, element, properties, values.data(), names.size());
}

inline void sort_ply_columns(std::vector<PlyColumn>& columns) {
  std::sort(columns.begin(), columns.end(), [](auto& a, auto& b) { return a.property < b.property; });
}

/// What stands for 1 in an attribute: that of its largest type. The columns that were added last are brought to it.
inline double unite(std::vector<PlyColumn>& columns, const PlyAttribute& attribute) {
  double most = 0;
  const auto begin = columns.end() - static_cast<std::ptrdiff_t>(attribute.properties.size());
  for (auto column = begin; column != columns.end(); ++column) most = std::max(most, full(column->type));
  for (auto column = begin; column != columns.end() && attribute.name == "color"; ++column) {
    column->factor = most / full(column->type);
  }
  return most;
}

}  // namespace detail

/// Where the numbers of vertices go in the mesh, in the order of the file; gives them room.
[[nodiscard]] inline std::vector<PlyColumn> vertex_columns(const PlyElement& vertex, bool has_wedges, MeshData& mesh) {
  std::vector<PlyColumn> columns;
  detail::add_ply_columns(columns, vertex, mesh.vertices, {"x", "y", "z"});
  detail::add_ply_columns(columns, vertex, mesh.normals, {"nx", "ny", "nz"});
  const std::array<std::vector<const char*>, 4> uv_names = {
      {{"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}}};
  for (const auto& names : uv_names) {
    if (mesh.uvs.empty() && !has_wedges) detail::add_ply_columns(columns, vertex, mesh.uvs, names);
  }
  for (const PlyAttribute& a : ply_attributes(vertex)) {
    const std::size_t width = a.properties.size();
    std::vector<double> values(width * static_cast<std::size_t>(vertex.count));
    detail::add_ply_columns(columns, vertex, a.properties, values.data(), width);
    mesh.attributes.push_back({"vertex_" + a.name, width, false, std::move(values), detail::unite(columns, a)});
  }
  detail::sort_ply_columns(columns);
  return columns;
}

/// The same for the numbers of faces, which go into a row, one attribute after the other: how many triangles a face is
/// is known only when it has been read.
[[nodiscard]] inline std::vector<PlyColumn> face_columns(const PlyElement& face, MeshData& mesh,
                                                         std::vector<double>& row) {
  const std::vector<PlyAttribute> attributes = ply_attributes(face);
  std::size_t size = 0;
  for (const PlyAttribute& a : attributes) size += a.properties.size();
  row.assign(size, 0.0);
  std::vector<PlyColumn> columns;
  for (double* first = row.data(); const PlyAttribute& a : attributes) {
    detail::add_ply_columns(columns, face, a.properties, first, 0);
    first += a.properties.size();
    mesh.attributes.push_back({"face_" + a.name, a.properties.size(), true, {}, detail::unite(columns, a)});
  }
  detail::sort_ply_columns(columns);
  return columns;
}

/// Tells the properties of which no numbers are kept: all but those of columns and the lists that are read.
inline void tell_unused(const PlyElement& element, const std::vector<PlyColumn>& columns,
                        const std::vector<std::size_t>& lists, WordAccount& account) {
  std::vector<bool> used(element.properties.size());
  for (const PlyColumn& column : columns) used[column.property] = true;
  for (const std::size_t list : lists) used[list] = true;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const PlyProperty& property = element.properties[i];
    if (!used[i]) account.tell(property.name, "is a property that is not used", property.line);
  }
}

}  // namespace equaltime
