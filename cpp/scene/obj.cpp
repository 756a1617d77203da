#include "scene/obj.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "scene/file_bytes.h"
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
  std::uint64_t largest = 0, largest_line = 0;  // the row that faces name furthest on, from 1, and where

  [[nodiscard]] std::uint64_t count() const noexcept { return values.size() / width; }
};

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, const std::optional<std::string>& material)
      : bytes_(path), lines_(bytes_), material_(material), wanted_(!material || material->empty()) {}

  MeshData read() {
    for (std::string_view line; next_statement(line);) statement(TextScanner(line.substr(0, line.find('#'))));
    for (const Rows& rows : rows_) check_range(rows);
    table_ = {};
    mesh_.vertices = expand(0);
    if (names_some(2)) mesh_.normals = expand(2);
    if (names_some(1)) mesh_.uvs = expand(1);
    if (ignored_ > 0) {
      mesh_.warnings.push_back("line " + std::to_string(ignored_line_) + ": " + std::to_string(ignored_) +
                               (ignored_ == 1 ? " statement was" : " statements were") +
                               " ignored, from here on: not v, vt, vn or f");
    }
    finish_mesh(mesh_, bytes_.path(), dropped_, [this](std::uint32_t i) { return vertex_place(corners_[i][0]); });
    return std::move(mesh_);
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
    if (word == "f") return wanted_ ? face(scan) : void();
    if (word == "usemtl") return void(wanted_ = !material_ || scan.rest() == *material_);
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
      const std::uint32_t at = table_.number(corner(scan), corners_);
      if (n == 0) first = at;
      if (n >= 2) mesh_.faces.insert(mesh_.faces.end(), {first, last, at});
      last = at;
    }
    if (n < 3) ++dropped_;
    if (corners_.size() >= kNone) lines_.fail("more than 2^32 - 2 different corners");
  }
  // "v", "v/vt", "v//vn", "v/vt/vn"; a part that is empty is missing.
  Corner corner(TextScanner& scan) {
    Corner corner = {kNone, kNone, kNone};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      if (kind > 0 && !scan.take('/')) break;
      std::int64_t index = 0;
      if (scan.digits(index)) {
        corner[kind] = resolve(index, rows_[kind]);
      } else if (kind == 0) {
        lines_.fail("expected a corner v, v/vt, v//vn or v/vt/vn, found " + scan.found());
      }
    }
    if (!scan.word_ends()) lines_.fail("expected a corner v, v/vt, v//vn or v/vt/vn, found " + scan.found());
    return corner;
  }
  std::uint32_t resolve(std::int64_t index, Rows& rows) {
    if (index == 0) lines_.fail(std::string(rows.noun) + " 0 does not exist: they count from 1");
    const auto count = static_cast<std::int64_t>(rows.count());
    if (index < -count) {
      lines_.fail(std::string(rows.noun) + " " + std::to_string(index) + " does not exist: " + std::to_string(count) +
                  " before this line");
    }
    const auto row = static_cast<std::uint64_t>(index > 0 ? index : count + index + 1);
    if (row > rows.largest) rows.largest = row, rows.largest_line = lines_.number();
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(row, kNone)) - 1;
  }

  // Faces may come before their vertices, so this is known at the end only.
  void check_range(const Rows& rows) const {
    if (rows.largest <= rows.count()) return;
    throw MeshError(path() + ":" + std::to_string(rows.largest_line) + ": " + rows.noun + " " +
                    std::to_string(rows.largest) + " does not exist: the file has " + std::to_string(rows.count()));
  }
  bool names_some(std::size_t kind) const noexcept { return rows_[kind].largest > 0; }

  std::vector<double> expand(std::size_t kind) {
    const std::size_t width = rows_[kind].width;
    std::vector<double> values(width * corners_.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const std::uint32_t row = corners_[i][kind];
      if (row != kNone) std::copy_n(rows_[kind].values.data() + width * row, width, values.data() + width * i);
    }
    rows_[kind].values = {};
    return values;
  }

  std::string vertex_place(std::uint32_t row) const {
    const auto at = std::find_if(suspects_.begin(), suspects_.end(), [row](auto& s) { return s.first == row; });
    const std::string line = at == suspects_.end() ? "" : ":" + std::to_string(at->second);
    return path() + line + ": vertex " + std::to_string(row + std::uint64_t{1});
  }

  FileBytes bytes_;
  Lines lines_;
  std::optional<std::string> material_;
  bool wanted_;  // the faces that come now
  std::array<Rows, 3> rows_ = {Rows{"vertex", 3}, Rows{"vt", 2}, Rows{"vn", 3}};
  std::vector<Corner> corners_;
  CornerTable table_;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> suspects_;  // rows of v that are not finite, and their lines
  std::uint64_t dropped_ = 0, ignored_ = 0, ignored_line_ = 0;
  std::string joined_;
  MeshData mesh_;
};

}  // namespace

MeshData read_obj(const std::filesystem::path& path, const std::optional<std::string>& material) {
  return ObjReader(path, material).read();
}

}  // namespace equaltime
