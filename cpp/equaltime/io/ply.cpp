#include "equaltime/io/ply.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include "equaltime/io/ears.h"
#include "equaltime/io/ply_columns.h"
#include "equaltime/io/ply_header.h"
#include "equaltime/io/wedges.h"

namespace equaltime {
namespace {

class PlyReader {
 public:
  PlyReader(FileBytes& bytes, Lines& lines, PlyHeader& header, const PlyMesh& mesh)
      : bytes_(bytes),
        lines_(lines),
        header_(header),
        vertex_(mesh.vertex),
        face_(mesh.face),
        indices_(mesh.indices),
        uvs_(mesh.wedges) {}

  MeshData read() {
    for (const PlyElement& element : header_.elements) {
      if (element.properties.empty()) continue;
      check_room(element);
      if (&element == vertex_) {
        read_vertices();
      } else if (&element == face_) {
        read_faces();
      } else {
        if (element.count > 0) header_.account.tell(element.name, "is an element that is not used", element.line);
        is_ascii() ? ascii_skipped(element) : binary_listed(element);
      }
    }
    return finished();
  }

 private:
  [[nodiscard]] bool is_ascii() const noexcept { return header_.format == PlyFormat::ascii; }

  void read_vertices() {
    columns_ = vertex_columns(*vertex_, uvs_.has_value(), mesh_);
    tell_unused(*vertex_, columns_, {}, header_.account);
    vertex_begin_ = bytes_.offset();
    is_ascii() ? ascii_vertices() : vertex_->has_list() ? binary_listed(*vertex_) : binary_vertices();
  }
  void read_faces() {
    face_columns_ = face_columns(*face_, mesh_, row_);
    tell_unused(*face_, face_columns_, {indices_, uvs_.value_or(indices_)}, header_.account);
    mesh_.faces.reserve(3 * static_cast<std::size_t>(std::min(face_->count, most_triangles())));
    is_ascii() ? ascii_faces() : binary_listed(*face_);
  }
  MeshData finished() {
    tell_rest();
    if (uvs_) wedges_.apply(mesh_);
    const UncutFaces uncut = cut_concave_faces(mesh_, fans_);
    mesh_.files = header_.images;
    header_.account.add_to(mesh_.warnings);
    if (uncut.count > 0) {
      mesh_.warnings.push_back("face " + std::to_string(uncut.first_place) + " (counted from 0) " + kUncutFace +
                               (uncut.count > 1 ? " (first of " + std::to_string(uncut.count) + ")" : ""));
    }
    finish_mesh(mesh_, bytes_.path(), dropped_, [this](std::uint32_t i) { return vertex_place(i); });
    return std::move(mesh_);
  }
  // Whatever follows the last element that the header declares; lines with nothing on them do not count.
  void tell_rest() {
    if (is_ascii()) {
      for (std::string_view line; lines_.next(line);) {
        if (!TextScanner(line).line_ends())
          return mesh_.warnings.push_back("line " + std::to_string(lines_.number()) +
                                          ": text after the last element is not read");
      }
    } else if (const std::uint64_t rest = bytes_.remaining(); rest > 0) {
      mesh_.warnings.push_back(std::to_string(rest) + " bytes after the last element are not read");
    }
  }

  [[noreturn]] void fail(const std::string& message) const {
    throw MeshError((is_ascii() ? lines_.place() : place_at(bytes_.offset())) + message);
  }
  std::string place_at(std::uint64_t offset) const {
    return bytes_.path().string() + ": byte offset " + std::to_string(offset) + ": ";
  }

  // A text has a character for every value and one between two.
  void check_room(const PlyElement& element) const {
    const bool ascii = is_ascii();
    const std::uint64_t least = ascii ? 2 * element.properties.size() : element.least_bytes();
    if (element.count <= (bytes_.remaining() + (ascii ? 1 : 0)) / least) return;
    fail("the header declares " + std::to_string(element.count) + " elements '" + element.name + "' of at least " +
         std::to_string(least) + " bytes, but only " + std::to_string(bytes_.remaining()) + " bytes follow");
  }
  std::uint64_t most_triangles() const {
    const PlyProperty& list = face_->properties[indices_];
    return bytes_.remaining() / (is_ascii() ? 8 : size_of(*list.list_count) + 3 * size_of(list.type)) + 1;
  }

  // What is kept of an element's numbers; of any but vertices and faces nothing.
  const std::vector<PlyColumn>& columns_of(const PlyElement& element) const noexcept {
    static const std::vector<PlyColumn> none;
    return &element == vertex_ ? columns_ : &element == face_ ? face_columns_ : none;
  }

  // ---- binary
  void need(std::uint64_t n, const char* what) {
    if (n > bytes_.remaining() || bytes_.ensure(static_cast<std::size_t>(n)) < n) {
      fail(std::string("the file ends within the ") + what);
    }
  }

  void binary_vertices() {
    const auto stride = std::max<std::size_t>(1, static_cast<std::size_t>(vertex_->least_bytes()));
    const std::size_t most = std::max<std::size_t>(1, (std::size_t{1} << 18) / stride);
    for (std::size_t done = 0, n = 0; done < vertex_->count; done += n) {
      n = std::min(most, static_cast<std::size_t>(vertex_->count) - done);
      need(n * stride, "vertices");
      for (const PlyColumn& column : columns_) copy(column, bytes_.data() + column.byte, stride, done, n);
      bytes_.advance(n * stride);
    }
  }
  void copy(const PlyColumn& column, const char* from, std::size_t stride, std::size_t first, std::size_t n) const {
    with_type(column.type, [&, swap = swap()](auto type) {
      double* to = column.first + first * column.stride;
      for (std::size_t i = 0; i < n; ++i, from += stride, to += column.stride) {
        *to = column.factor * static_cast<double>(load<typename decltype(type)::type>(from, swap));
      }
    });
  }

  // Any element, record by record: the one way to read faces, and what it takes to step over lists elsewhere.
  void binary_listed(const PlyElement& element) {
    if (!element.has_list()) {
      if (!bytes_.skip(element.count * element.least_bytes())) fail("the file ends within '" + element.name + "'");
      return;
    }
    const std::vector<PlyColumn>& columns = columns_of(element);
    for (std::uint64_t record = 0; record < element.count; ++record) {
      auto column = columns.begin();
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        if (property.list_count) {
          binary_list(property, &element == face_ && i == indices_, &element == face_ && i == uvs_);
          continue;
        }
        need(size_of(property.type), element.name.c_str());
        if (column != columns.end() && column->property == i) {
          copy(*column++, bytes_.data(), 0, static_cast<std::size_t>(record), 1);
        }
        bytes_.advance(size_of(property.type));
      }
      if (&element == face_) end_face(record);
    }
  }
  void binary_list(const PlyProperty& property, bool corners, bool uvs) {
    need(size_of(*property.list_count), "list");
    const std::int64_t n = integer(*property.list_count);
    if (n < 0) fail("a list has the length " + std::to_string(n));
    bytes_.advance(size_of(*property.list_count));
    const std::uint64_t size = static_cast<std::uint64_t>(n) * size_of(property.type);
    if (!corners && !uvs) {
      if (!bytes_.skip(size)) fail("the file ends within a list");
      return;
    }
    need(size, "face");
    with_type(property.type, [&, swap = swap()](auto type) {
      using T = typename decltype(type)::type;
      const char* at = bytes_.data();
      if (uvs) {
        for (std::int64_t k = 0; k < n; ++k, at += sizeof(T))
          face_uvs_.push_back(static_cast<double>(load<T>(at, swap)));
      } else if constexpr (std::is_integral_v<T>) {
        for (std::int64_t k = 0; k < n; ++k, at += sizeof(T)) add_corner(load<T>(at, swap));
      }
    });
    bytes_.advance(static_cast<std::size_t>(size));
  }
  std::int64_t integer(PlyType type) const {
    return with_type(type, [&](auto t) {
      return static_cast<std::int64_t>(load<typename decltype(t)::type>(bytes_.data(), swap()));
    });
  }
  bool swap() const noexcept {
    return (header_.format == PlyFormat::big) == (std::endian::native == std::endian::little);
  }

  // ---- ascii: an element has a line; lines with nothing on them do not count
  TextScanner next_line(const PlyElement& element, std::uint64_t i) {
    for (std::string_view line; lines_.next(line);) {
      if (TextScanner scan(line); !scan.line_ends()) return scan;
    }
    fail("the file ends before element " + std::to_string(i) + " of " + std::to_string(element.count) + " '" +
         element.name + "'");
  }
  double number(TextScanner& scan, const PlyProperty& property) const {
    double value = 0;
    if (!scan.number(value)) fail("expected a number for '" + property.name + "', found " + scan.found());
    return value;
  }
  std::int64_t integer(TextScanner& scan, const PlyProperty& property) const {
    std::int64_t value = 0;
    if (!scan.integer(value)) fail("expected an integer for '" + property.name + "', found " + scan.found());
    return value;
  }

  template <typename Scalar, typename List>
  void ascii_record(TextScanner& scan, const PlyElement& element, Scalar&& scalar, List&& list) {
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (!property.list_count) {
        scalar(i, number(scan, property));
        continue;
      }
      const std::int64_t n = integer(scan, property);
      if (n < 0) fail("a list has the length " + std::to_string(n));
      list(i, n);
    }
    if (!scan.line_ends()) fail("more values than properties: " + scan.found());
  }
  void step_over(TextScanner& scan, const PlyProperty& list, std::int64_t n) const {
    for (std::int64_t k = 0; k < n; ++k) number(scan, list);
  }

  auto keep(const PlyElement& element, std::uint64_t record) const {
    const std::vector<PlyColumn>& columns = columns_of(element);
    return [record, column = columns.begin(), end = columns.end()](std::size_t i, double value) mutable {
      if (column == end || column->property != i) return;
      column->first[static_cast<std::size_t>(record) * column->stride] = column->factor * value, ++column;
    };
  }

  void ascii_vertices() {
    for (std::uint64_t v = 0; v < vertex_->count; ++v) {
      TextScanner scan = next_line(*vertex_, v);
      ascii_record(scan, *vertex_, keep(*vertex_, v),
                   [&](std::size_t i, std::int64_t n) { step_over(scan, vertex_->properties[i], n); });
      const double* p = mesh_.vertices.data() + 3 * v;
      if (!std::isfinite(p[0] + p[1] + p[2])) suspects_.push_back({v, lines_.number()});
    }
  }
  void ascii_faces() {
    for (std::uint64_t f = 0; f < face_->count; ++f) {
      TextScanner scan = next_line(*face_, f);
      ascii_record(scan, *face_, keep(*face_, f), [&](std::size_t i, std::int64_t n) {
        const PlyProperty& list = face_->properties[i];
        if (i == indices_) {
          for (std::int64_t k = 0; k < n; ++k) add_corner(integer(scan, list));
        } else if (i == uvs_) {
          for (std::int64_t k = 0; k < n; ++k) face_uvs_.push_back(number(scan, list));
        } else {
          step_over(scan, list, n);
        }
      });
      end_face(f);
    }
  }
  void ascii_skipped(const PlyElement& element) {
    for (std::uint64_t i = 0; i < element.count; ++i) next_line(element, i);
  }

  // ---- faces: the corners of the face being read end the faces of the mesh; most are a triangle and stay
  void add_corner(std::int64_t index) {
    if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_->count) {
      fail("face with vertex index " + std::to_string(index) + ": the file has the vertices 0 to " +
           std::to_string(vertex_->count - 1));
    }
    mesh_.faces.push_back(static_cast<std::uint32_t>(index));
  }
  void end_face(std::uint64_t record) {
    if (uvs_) give_uvs();
    if (mesh_.faces.size() != face_begin_ + 3) make_fan(record);
    face_begin_ = mesh_.faces.size();
    if (!row_.empty()) give_row();
  }
  // Triangles round the first corner, until all faces are read.
  void make_fan(std::uint64_t record) {
    const auto begin = mesh_.faces.begin() + static_cast<std::ptrdiff_t>(face_begin_);
    const std::vector<std::uint32_t> corners(begin, mesh_.faces.end());
    mesh_.faces.erase(begin, mesh_.faces.end());
    if (corners.size() < 3) {
      ++dropped_;
      return;
    }
    fans_.push_back({face_begin_ / 3, corners.size() - 2, record});
    for (std::size_t k = 2; k < corners.size(); ++k) {
      mesh_.faces.insert(mesh_.faces.end(), {corners[0], corners[k - 1], corners[k]});
    }
  }
  // A list without exactly two numbers for each corner gives no coordinates: they become NaN.
  void give_uvs() {
    const std::size_t corners = mesh_.faces.size() - face_begin_;
    if (face_uvs_.size() != 2 * corners) face_uvs_.assign(2 * corners, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < corners; ++k) {
      std::uint32_t& corner = mesh_.faces[face_begin_ + k];
      corner = wedges_.number(corner, face_uvs_[2 * k], face_uvs_[2 * k + 1]);
    }
    if (wedges_.count() >= std::numeric_limits<std::uint32_t>::max()) fail("more than 2^32 - 2 different corners");
    face_uvs_.clear();
  }
  // Each new triangle has the attributes of the face that it is of.
  void give_row() {
    const double* values = row_.data();
    for (MeshAttributeData& a : mesh_.attributes) {
      if (!a.per_face) continue;
      while (a.values.size() < mesh_.faces.size() / 3 * a.width)
        a.values.insert(a.values.end(), values, values + a.width);
      values += a.width;
    }
  }

  std::string vertex_place(std::uint32_t number) const {
    const std::uint32_t i = uvs_ ? wedges_.vertex(number) : number;
    const auto found = std::find_if(suspects_.begin(), suspects_.end(), [i](auto& s) { return s.first == i; });
    const std::uint64_t record = vertex_->has_list() ? 0 : i * vertex_->least_bytes();
    const std::string place = !is_ascii() ? place_at(vertex_begin_ + record)
                              : found != suspects_.end()
                                  ? bytes_.path().string() + ":" + std::to_string(found->second) + ": "
                                  : bytes_.path().string() + ": ";
    return place + "vertex " + std::to_string(i) + " (counted from 0)";
  }

  FileBytes& bytes_;
  Lines& lines_;
  PlyHeader& header_;
  const PlyElement* vertex_;
  const PlyElement* face_;
  std::size_t indices_;             // the property of the faces that lists their vertices
  std::optional<std::size_t> uvs_;  // the one that lists the uvs of their corners
  std::vector<PlyColumn> columns_, face_columns_;
  std::vector<double> row_;  // the attributes of the face being read
  std::uint64_t vertex_begin_ = 0, dropped_ = 0;
  std::size_t face_begin_ = 0;    // where the corners of the face being read begin in the faces of the mesh
  std::vector<double> face_uvs_;  // of the face being read
  std::vector<FannedFace> fans_;
  Wedges wedges_;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> suspects_;  // vertices that are not finite, and their lines
  MeshData mesh_;
};

}  // namespace

MeshData read_ply(const std::filesystem::path& path) {
  FileBytes bytes(path);
  Lines lines(bytes);
  PlyHeader header = read_ply_header(lines);
  if (header.format != PlyFormat::ascii) lines.release();
  return PlyReader(bytes, lines, header, find_mesh(header, path)).read();
}

}  // namespace equaltime
