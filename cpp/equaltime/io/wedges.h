// Vertices of faces that bring uvs of their own: one for each different pair of a vertex and a uv, in the order in
// which they come.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "equaltime/io/corner_table.h"
#include "equaltime/io/mesh_data.h"

namespace equaltime {

class Wedges {
 public:
  std::uint32_t number(std::uint32_t vertex, double u, double v) {
    const auto a = std::bit_cast<std::uint64_t>(u), b = std::bit_cast<std::uint64_t>(v);
    const auto low = [](std::uint64_t x) { return static_cast<std::uint32_t>(x); };
    const auto high = [](std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); };
    return table_.number({vertex, low(a), high(a), low(b), high(b)}, corners_);
  }

  /// The vertex of the file that a new one stands for.
  [[nodiscard]] std::uint32_t vertex(std::uint32_t number) const noexcept { return corners_[number][0]; }
  [[nodiscard]] std::uint64_t count() const noexcept { return corners_.size(); }

  /// Gives a mesh the new vertices, which its faces name already.
  void apply(MeshData& mesh) const {
    expand(mesh.vertices, 3);
    if (!mesh.normals.empty()) expand(mesh.normals, 3);
    for (MeshAttributeData& a : mesh.attributes) {
      if (!a.per_face) expand(a.values, a.width);
    }
    mesh.uvs.clear();
    mesh.uvs.reserve(2 * corners_.size());
    for (const auto& c : corners_) {
      mesh.uvs.push_back(std::bit_cast<double>(c[1] | std::uint64_t{c[2]} << 32));
      mesh.uvs.push_back(std::bit_cast<double>(c[3] | std::uint64_t{c[4]} << 32));
    }
  }

 private:
  using Table = CornerTable<5>;

  void expand(std::vector<double>& rows, std::size_t width) const {
    std::vector<double> values(width * corners_.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      std::copy_n(rows.data() + width * corners_[i][0], width, values.data() + width * i);
    }
    rows = std::move(values);
  }

  Table table_;
  std::vector<Table::Corner> corners_;
};

}  // namespace equaltime
