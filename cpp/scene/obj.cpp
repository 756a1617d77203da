#include "scene/obj.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "scene/file_bytes.h"
#include "scene/release.h"
#include "scene/text_scanner.h"

namespace equaltime {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

// The rows of v, vt and vn that a corner of a face names, from 0; kNone where it names none.
using Corner = std::array<std::uint32_t, 3>;

// Numbers different corners 0, 1, 2 … in the order in which they come: open addressing over a power of two, at most
// half full, that keeps the numbers only.
class CornerTable {
 public:
  std::uint32_t number(const Corner& corner, std::vector<Corner>& corners) {
    if (2 * (corners.size() + 1) > slots_.size()) grow(corners);
    std::uint32_t& slot = *find(corner, corners);
    if (slot == kNone) {
      slot = static_cast<std::uint32_t>(corners.size());
      corners.push_back(corner);
    }
    return slot;
  }

 private:
  static std::uint64_t hash(const Corner& c) noexcept {
    std::uint64_t h = c[0] * 0x9e3779b97f4a7c15u;
    h = (h ^ (h >> 32) ^ c[1]) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 29) ^ c[2]) * 0x94d049bb133111ebu;
    return h ^ (h >> 32);
  }
  std::uint32_t* find(const Corner& corner, const std::vector<Corner>& corners) noexcept {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t i = hash(corner) & mask;; i = (i + 1) & mask) {
      if (slots_[i] == kNone || corners[slots_[i]] == corner) return &slots_[i];
    }
  }
  void grow(const std::vector<Corner>& corners) {
    slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kNone);
    for (std::size_t i = 0; i < corners.size(); ++i) *find(corners[i], corners) = static_cast<std::uint32_t>(i);
  }

  std::vector<std::uint32_t> slots_;
};

// One kind of row of the file: v, vt or vn.
struct Rows {
  const char* noun;
  std::size_t width;
  std::vector<double> values{};

  [[nodiscard]] std::uint64_t count() const noexcept { return values.size() / width; }
};

// Faces that make one mesh.
struct Part {
  std::vector<Corner> corners{};
  CornerTable table{};
  std::vector<std::uint32_t> faces{};
  std::uint64_t dropped = 0;
  // Of each kind, the row that faces name furthest on, from 1, and where.
  std::array<std::uint64_t, 3> largest{}, largest_line{};
};

class ObjReader {
 public:
  // Faces after a usemtl go into the part of its name, if there is one; those before any, into that of "".
  ObjReader(const std::filesystem::path& path, std::function<Part*(std::string_view)> part_of)
      : bytes_(path), lines_(bytes_), part_of_(std::move(part_of)), part_(part_of_("")) {}

  void read() {
    for (std::string_view line; next_statement(line);) statement(TextScanner(line.substr(0, line.find('#'))));
  }

  // The mesh of a part. With the last, the rows are given up.
  MeshData mesh(Part&& part, bool last) {
    for (std::size_t kind = 0; kind < 3; ++kind) check_range(part, kind);
    part.table = {};
    MeshData mesh;
    mesh.faces = std::move(part.faces);
    mesh.vertices = expand(part, 0, last);
    if (part.largest[2] > 0) mesh.normals = expand(part, 2, last);
    if (part.largest[1] > 0) mesh.uvs = expand(part, 1, last);
    if (ignored_ > 0) {
      mesh.warnings.push_back("line " + std::to_string(ignored_line_) + ": " + std::to_string(ignored_) +
                              (ignored_ == 1 ? " statement was" : " statements were") +
                              " ignored, from here on: not v, vt, vn or f");
    }
    finish_mesh(mesh, bytes_.path(), part.dropped, [&](std::uint32_t i) { return vertex_place(part.corners[i][0]); });
    return mesh;
  }

 private:
  std::string path() const { return bytes_.path().string(); }

  // A line that ends in a backslash goes on in the next one.
  bool next_statement(std::string_view& line) {
    if (!lines_.next(line)) return false;
    if (lines_.number() == 1 && line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
    if (line.empty() || line.back() != '\\') return true;
    joined_.clear();
    do {
      joined_.append(line.substr(0, line.size() - 1)) += ' ';
      line = {};
    } while (lines_.next(line) && !line.empty() && line.back() == '\\');
    line = joined_.append(line);
    return true;
  }

  void statement(TextScanner scan) {
    static constexpr std::string_view silent[] = {"o", "g", "s", "mg", "mtllib", "usemap", "maplib", "vp"};
    const std::string_view word = scan.word();
    if (word.empty()) return;
    if (word == "v") return vertex(scan);
    if (word == "vn") return row(scan, rows_[2], 3);
    if (word == "vt") return row(scan, rows_[1], 1);
    if (word == "f") return part_ != nullptr ? face(scan) : void();
    if (word == "usemtl") return void(part_ = part_of_(scan.rest()));
    if (std::find(std::begin(silent), std::end(silent), word) != std::end(silent)) return;
    if (ignored_++ == 0) ignored_line_ = lines_.number();
  }

  // `least` numbers have to be there, the others of the row are 0 if they are not; what follows the row is left alone
  // (colours, weights).
  void row(TextScanner& scan, Rows& rows, std::size_t least) {
    for (std::size_t k = 0; k < rows.width; ++k) {
      double value = 0;
      if (!scan.number(value) && (k < least || !scan.line_ends())) {
        lines_.fail("expected a number, found " + scan.found());
      }
      rows.values.push_back(value);
    }
    if (rows.count() >= kNone) lines_.fail(std::string("too many rows of ") + rows.noun);
  }
  void vertex(TextScanner& scan) {
    Rows& rows = rows_[0];
    row(scan, rows, 3);
    const double* p = rows.values.data() + rows.values.size() - 3;
    if (!std::isfinite(p[0] + p[1] + p[2])) {
      suspects_.emplace_back(static_cast<std::uint32_t>(rows.count() - 1), lines_.number());
    }
  }

  void face(TextScanner& scan) {
    std::uint32_t first = 0, last = 0;
    std::uint64_t n = 0;
    for (; !scan.line_ends(); ++n) {
      const std::uint32_t at = part_->table.number(corner(scan), part_->corners);
      if (n == 0) first = at;
      if (n >= 2) part_->faces.insert(part_->faces.end(), {first, last, at});
      last = at;
    }
    if (n < 3) ++part_->dropped;
    if (part_->corners.size() >= kNone) lines_.fail("more than 2^32 - 2 different corners");
  }
  // "v", "v/vt", "v//vn", "v/vt/vn"; a part that is empty is missing.
  Corner corner(TextScanner& scan) {
    Corner corner = {kNone, kNone, kNone};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      if (kind > 0 && !scan.take('/')) break;
      std::int64_t index = 0;
      if (scan.digits(index)) {
        corner[kind] = resolve(index, kind);
      } else if (kind == 0) {
        lines_.fail("expected a corner v, v/vt, v//vn or v/vt/vn, found " + scan.found());
      }
    }
    if (!scan.word_ends()) lines_.fail("expected a corner v, v/vt, v//vn or v/vt/vn, found " + scan.found());
    return corner;
  }
  std::uint32_t resolve(std::int64_t index, std::size_t kind) {
    const Rows& rows = rows_[kind];
    if (index == 0) lines_.fail(std::string(rows.noun) + " 0 does not exist: they count from 1");
    const auto count = static_cast<std::int64_t>(rows.count());
    if (index < -count) {
      lines_.fail(std::string(rows.noun) + " " + std::to_string(index) + " does not exist: " + std::to_string(count) +
                  " before this line");
    }
    const auto row = static_cast<std::uint64_t>(index > 0 ? index : count + index + 1);
    if (row > part_->largest[kind]) part_->largest[kind] = row, part_->largest_line[kind] = lines_.number();
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(row, kNone)) - 1;
  }

  // Faces may come before their vertices, so this is known at the end only.
  void check_range(const Part& part, std::size_t kind) const {
    const Rows& rows = rows_[kind];
    if (part.largest[kind] <= rows.count()) return;
    throw MeshError(path() + ":" + std::to_string(part.largest_line[kind]) + ": " + rows.noun + " " +
                    std::to_string(part.largest[kind]) + " does not exist: the file has " +
                    std::to_string(rows.count()));
  }

  std::vector<double> expand(const Part& part, std::size_t kind, bool last) {
    const std::size_t width = rows_[kind].width;
    std::vector<double> values(width * part.corners.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < part.corners.size(); ++i) {
      const std::uint32_t row = part.corners[i][kind];
      if (row != kNone) std::copy_n(rows_[kind].values.data() + width * row, width, values.data() + width * i);
    }
    if (last) release(rows_[kind].values);
    return values;
  }

  std::string vertex_place(std::uint32_t row) const {
    const auto at = std::find_if(suspects_.begin(), suspects_.end(), [row](auto& s) { return s.first == row; });
    const std::string line = at == suspects_.end() ? "" : ":" + std::to_string(at->second);
    return path() + line + ": vertex " + std::to_string(row + std::uint64_t{1});
  }

  FileBytes bytes_;
  Lines lines_;
  std::function<Part*(std::string_view)> part_of_;
  Part* part_;  // of the faces that come now; null: they are not wanted
  std::array<Rows, 3> rows_ = {Rows{"vertex", 3}, Rows{"vt", 2}, Rows{"vn", 3}};
  std::vector<std::pair<std::uint32_t, std::uint64_t>> suspects_;  // rows of v that are not finite, and their lines
  std::uint64_t ignored_ = 0, ignored_line_ = 0;
  std::string joined_;
};

}  // namespace

MeshData read_obj(const std::filesystem::path& path, const std::optional<std::string>& material) {
  Part part;
  ObjReader reader(path, [&](std::string_view name) { return !material || name == *material ? &part : nullptr; });
  reader.read();
  return reader.mesh(std::move(part), true);
}

std::map<std::string, MeshData> read_obj_by_material(const std::filesystem::path& path) {
  std::map<std::string, Part, std::less<>> parts;
  ObjReader reader(path, [&](std::string_view name) {
    const auto found = parts.find(name);
    return found != parts.end() ? &found->second : &parts[std::string(name)];
  });
  reader.read();
  std::erase_if(parts, [](const auto& part) { return part.second.faces.empty(); });
  std::map<std::string, MeshData> meshes;
  while (!parts.empty()) {
    auto part = parts.extract(parts.begin());
    meshes.emplace(part.key(), reader.mesh(std::move(part.mapped()), parts.empty()));
  }
  return meshes;
}

}  // namespace equaltime
