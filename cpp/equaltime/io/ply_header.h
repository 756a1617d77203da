// The header of a PLY file: which elements follow, in which order, made of which properties, and which of them are the
// mesh.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "equaltime/io/file_bytes.h"
#include "equaltime/io/text_scanner.h"
#include "equaltime/io/word_account.h"

namespace equaltime {

enum class PlyFormat : std::uint8_t { ascii, little, big };
enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

inline std::size_t size_of(PlyType type) noexcept {
  constexpr std::size_t sizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}
inline bool is_float(PlyType type) noexcept { return type >= PlyType::float32; }
// The value that stands for 1 in a colour of this type.
inline double full(PlyType type) noexcept {
  constexpr double largest[] = {127, 255, 32767, 65535, 2147483647, 4294967295, 1, 1};
  return largest[static_cast<std::size_t>(type)];
}

// A value of type T in a file's bytes.
template <typename T>
T load(const char* at, bool swap) noexcept {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swap) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

// Calls f with the C++ type that a PLY type names.
template <typename F>
auto with_type(PlyType type, F&& f) {
  switch (type) {
    case PlyType::int8:
      return f(std::type_identity<std::int8_t>{});
    case PlyType::uint8:
      return f(std::type_identity<std::uint8_t>{});
    case PlyType::int16:
      return f(std::type_identity<std::int16_t>{});
    case PlyType::uint16:
      return f(std::type_identity<std::uint16_t>{});
    case PlyType::int32:
      return f(std::type_identity<std::int32_t>{});
    case PlyType::uint32:
      return f(std::type_identity<std::uint32_t>{});
    case PlyType::float32:
      return f(std::type_identity<float>{});
    case PlyType::float64:
      break;
  }
  return f(std::type_identity<double>{});
}

struct PlyProperty {
  std::string name;
  PlyType type{};                     // of the value, or of the items of a list
  std::optional<PlyType> list_count;  // the type of a list's length; none for a scalar
  std::uint64_t line = 0;
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  std::uint64_t line = 0;

  [[nodiscard]] bool has_list() const noexcept {
    for (const PlyProperty& p : properties) {
      if (p.list_count) return true;
    }
    return false;
  }
  // What one element takes in a binary file, its lists being empty.
  [[nodiscard]] std::uint64_t least_bytes() const noexcept {
    std::uint64_t sum = 0;
    for (const PlyProperty& p : properties) sum += size_of(p.list_count.value_or(p.type));
    return sum;
  }
  [[nodiscard]] std::optional<std::size_t> find(std::string_view property) const noexcept {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].name == property) return i;
    }
    return std::nullopt;
  }
};

struct PlyHeader {
  PlyFormat format{};
  std::vector<PlyElement> elements;
  std::vector<NamedFile> images;  // of comments TextureFile
  WordAccount account;

  [[nodiscard]] const PlyElement* find(std::string_view element) const noexcept {
    for (const PlyElement& e : elements) {
      if (e.name == element) return &e;
    }
    return nullptr;
  }
};

inline PlyType ply_type(std::string_view word, const Lines& lines) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 8> names = {{{"char", "int8"},
                                                                                   {"uchar", "uint8"},
                                                                                   {"short", "int16"},
                                                                                   {"ushort", "uint16"},
                                                                                   {"int", "int32"},
                                                                                   {"uint", "uint32"},
                                                                                   {"float", "float32"},
                                                                                   {"double", "float64"}}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (word == names[i].first || word == names[i].second) return static_cast<PlyType>(i);
  }
  lines.fail("expected a PLY type (char uchar short ushort int uint float double), found " + TextScanner::quoted(word));
}

inline PlyFormat ply_format(TextScanner& scan, const Lines& lines) {
  const std::string_view name = scan.word(), version = scan.word();
  if (version != "1.0") lines.fail("expected version 1.0 of PLY, found " + TextScanner::quoted(version));
  if (name == "ascii") return PlyFormat::ascii;
  if (name == "binary_little_endian") return PlyFormat::little;
  if (name == "binary_big_endian") return PlyFormat::big;
  lines.fail("expected format ascii, binary_little_endian or binary_big_endian, found " + TextScanner::quoted(name));
}

inline PlyElement ply_element(TextScanner& scan, const PlyHeader& header, const Lines& lines) {
  PlyElement element;
  element.name = scan.word();
  if (header.find(element.name)) lines.fail("a second element " + TextScanner::quoted(element.name));
  std::int64_t count = 0;
  const std::string found = scan.found();
  if (!scan.integer(count) || count < 0) lines.fail("expected the number of elements, found " + found);
  element.count = static_cast<std::uint64_t>(count);
  element.line = lines.number();
  return element;
}

inline PlyProperty ply_property(TextScanner& scan, const PlyElement& element, const Lines& lines) {
  PlyProperty property;
  std::string_view type = scan.word();
  if (type == "list") {
    property.list_count = ply_type(scan.word(), lines);
    if (is_float(*property.list_count)) lines.fail("the length of a list must have an integer type");
    type = scan.word();
  }
  property.type = ply_type(type, lines);
  property.name = scan.word();
  property.line = lines.number();
  if (property.name.empty()) lines.fail("a property without a name");
  if (element.find(property.name)) lines.fail("a second property " + TextScanner::quoted(property.name));
  return property;
}

// A comment means nothing, but for the one by which MeshLab and others name an image.
inline void ply_comment(TextScanner& scan, PlyHeader& header, const Lines& lines) {
  if (scan.word() == "TextureFile") header.images.push_back({std::string(scan.rest()), lines.number()});
}

// Reads up to and with the line end_header.
inline PlyHeader read_ply_header(Lines& lines) {
  constexpr std::uint64_t kLongest = 10000;  // lines; a header has some twenty
  PlyHeader header;
  std::string_view line;
  if (!lines.next(line)) lines.fail("not a PLY file: it is empty");
  if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
  if (TextScanner(line).word() != "ply") {
    throw MeshError(lines.place() + "not a PLY file: it does not begin with 'ply'");
  }
  bool has_format = false;
  while (lines.number() < kLongest && lines.next(line)) {
    TextScanner scan(line);
    const std::string_view word = scan.word();
    if (word == "end_header") {
      if (!has_format) lines.fail("the header has no line 'format'");
      return header;
    }
    if (word.empty() || word == "obj_info") continue;  // a comment, too
    if (word == "comment") {
      ply_comment(scan, header, lines);
      continue;
    }
    if (word == "format") {
      header.format = ply_format(scan, lines), has_format = true;
    } else if (word == "element") {
      header.elements.push_back(ply_element(scan, header, lines));
    } else if (word == "property") {
      if (header.elements.empty()) lines.fail("a property before the first element");
      header.elements.back().properties.push_back(ply_property(scan, header.elements.back(), lines));
    } else {
      lines.fail("expected format, element, property, comment or end_header, found " + TextScanner::quoted(word));
    }
    if (!scan.line_ends()) header.account.tell(word, "has more words than are read", lines.number());
  }
  lines.fail("the file ends within its header: no line 'end_header'");
}

// Where in the file the mesh is.
struct PlyMesh {
  const PlyElement* vertex;
  const PlyElement* face;
  std::size_t indices;                // the property of the faces that lists their vertices
  std::optional<std::size_t> wedges;  // the one that lists the uvs of their corners
};

inline PlyMesh find_mesh(const PlyHeader& header, const std::filesystem::path& path) {
  const auto fail = [&](const std::string& text) { throw MeshError(path.string() + ": " + text); };
  const PlyElement *vertex = header.find("vertex"), *face = header.find("face");
  if (!vertex || vertex->count == 0) fail("the mesh is empty: the file has no vertices");
  if (vertex->count > std::numeric_limits<std::uint32_t>::max()) fail("more than 2^32 - 1 vertices");
  if (!face && header.find("tristrips")) fail("triangle strips are not supported: convert them to faces");
  if (!face || face->count == 0) fail("the mesh is empty: the file has no faces");
  for (const char* name : {"x", "y", "z"}) {
    const auto at = vertex->find(name);
    if (!at || vertex->properties[*at].list_count) fail(std::string("the vertices have no property '") + name + "'");
  }
  const auto indices = face->find("vertex_indices") ? face->find("vertex_indices") : face->find("vertex_index");
  if (!indices || !face->properties[*indices].list_count || is_float(face->properties[*indices].type)) {
    fail("the faces have no list 'vertex_indices' (or 'vertex_index') of an integer type");
  }
  std::optional<std::size_t> wedges = face->find("texcoord");
  if (wedges && !face->properties[*wedges].list_count) wedges.reset();
  return {vertex, face, *indices, wedges};
}

}  // namespace equaltime
