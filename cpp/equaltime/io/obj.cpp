#include "equaltime/io/obj.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <utility>

#include "equaltime/base/release.h"
#include "equaltime/io/corner_table.h"
#include "equaltime/io/ears.h"
#include "equaltime/io/file_bytes.h"
#include "equaltime/io/obj_words.h"
#include "equaltime/io/text_scanner.h"
#include "equaltime/io/word_account.h"

namespace equaltime {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr double kGrey = 0.5;  // the colour of a vertex that has none, where others have

// One kind of row of the file: v, vt or vn.
struct Rows {
  const char* noun;
  std::size_t width;
  std::vector<double> values{};

  [[nodiscard]] std::uint64_t count() const noexcept { return values.size() / width; }
};

// The rows of v, vt and vn that a corner of a face names, from 0; kNone where it names none.
using Corners = CornerTable<3>;

// Faces that make one mesh.
struct Part {
  std::vector<Corners::Corner> corners{};
  Corners table{};
  std::vector<std::uint32_t> faces{};
  std::vector<FannedFace> fans{};
  std::uint64_t dropped = 0, first_line = 0;
  // Of each kind, the row that faces name furthest on, from 1, and where.
  std::array<std::uint64_t, 3> largest{}, largest_line{};
};

// The colours behind the numbers of v: in [0, 1], or whole numbers to 255.
class Colors {
 public:
  void add(std::uint64_t row, const double* rgb, std::uint64_t line) {
    values_.resize(3 * static_cast<std::size_t>(row), kMissing);
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = rgb[k];
      whole_ = whole_ && value >= 0 && value <= 255 && value == std::floor(value);
      if (value > 1 && !is_beyond_) is_beyond_ = true, beyond_line_ = line;
      // The mesh tells of infinities when it is finished; NaN is taken for a missing colour here.
      values_.push_back(std::isnan(value) ? std::numeric_limits<double>::infinity() : value);
    }
  }
  // To be called when all rows are there.
  void finish(std::uint64_t rows, std::uint64_t colorless, std::uint64_t colorless_line, WordAccount& account) {
    if (values_.empty()) return;
    values_.resize(3 * static_cast<std::size_t>(rows), kMissing);
    const bool bytes = whole_ && is_beyond_;
    for (double& value : values_) value = std::isnan(value) ? kGrey : bytes ? value / 255 : value;
    if (bytes) account.tell("v", "has colours in whole numbers to 255, which are divided by it", beyond_line_);
    account.tell("v", "has no colour and is grey", colorless_line, colorless);
  }
  [[nodiscard]] const std::vector<double>& values() const noexcept { return values_; }

 private:
  static constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

  std::vector<double> values_;
  bool whole_ = true, is_beyond_ = false;
  std::uint64_t beyond_line_ = 0;
};

class ObjReader {
 public:
  // Faces after a usemtl go into the part of its name, if there is one; those before any, into that of "".
  ObjReader(const std::filesystem::path& path, std::function<Part*(std::string_view)> part_of)
      : bytes_(path), lines_(bytes_), part_of_(std::move(part_of)), part_(part_of_("")) {}

  void read() {
    for (std::string_view line; lines_.next(line);) take(lines_.number() == 1 ? without_mark(line) : line);
    colors_.finish(rows_[0].count(), colorless_, colorless_line_, account_);
  }

  // The mesh of a part. With the last, the rows are given up.
  MeshData mesh(Part&& part, bool last) {
    for (std::size_t kind = 0; kind < 3; ++kind) check_range(part, kind);
    part.table = {};
    MeshData mesh;
    mesh.faces = std::move(part.faces);
    mesh.files = files_;
    mesh.vertices = expand(part, 0, last);
    if (!colors_.values().empty()) {
      mesh.attributes.push_back({"vertex_color", 3, false, expand(part, 0, colors_.values(), 3)});
    }
    if (part.largest[2] > 0) mesh.normals = expand(part, 2, last);
    if (part.largest[1] > 0) mesh.uvs = expand(part, 1, last);
    WordAccount account = account_;
    if (part.largest[2] == 0 && smoothing_line_ > 0) account.tell("s", obj_word("s").why, smoothing_line_);
    const UncutFaces uncut = cut_concave_faces(mesh, part.fans);
    account.tell("f", kUncutFace, uncut.first_place, uncut.count);
    account.add_to(mesh.warnings);
    finish_mesh(mesh, bytes_.path(), part.dropped, [&](std::uint32_t i) { return vertex_place(part.corners[i][0]); });
    return mesh;
  }

 private:
  std::string path() const { return bytes_.path().string(); }

  std::string_view without_mark(std::string_view line) const {
    if (line.starts_with("\xff\xfe") || line.starts_with("\xfe\xff")) {
      lines_.fail("the text is in UTF-16: save it in UTF-8 or ASCII");
    }
    if (line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
    return line;
  }

  void take(std::string_view line) {
    if (const ObjWord* rule = frequent_obj_word(line)) return statement(*rule, TextScanner(whole(line)));
    const std::string_view first = TextScanner(line).word(), word = first.substr(0, first.find_first_of("#\\"));
    if (first.starts_with('\\')) {
      const bool goes_on = line.ends_with('\\') && TextScanner(line).rest() == first;
      return goes_on ? take(whole(line)) : account_.tell(first, kUnknownWord, lines_.number());
    }
    if (word.empty()) return comment(first);
    const ObjWord rule = obj_word(word);
    if (takes_name(rule.use)) {
      name(rule.use, line.substr(static_cast<std::size_t>(word.data() - line.data()) + word.size()));
    } else {
      statement(rule, TextScanner(whole(line)));
    }
  }

  // A statement without its comment. A line that ends in a backslash goes on in the next one.
  std::string_view whole(std::string_view line) {
    line = line.substr(0, line.find('#'));
    if (!line.ends_with('\\')) return line;
    joined_.clear();
    do {
      joined_.append(line.substr(0, line.size() - 1)) += ' ';
      if (!lines_.next(line)) return joined_;
      line = line.substr(0, line.find('#'));
    } while (line.ends_with('\\'));
    return joined_.append(line);
  }

  void comment(std::string_view word) {
    if (word.starts_with("#MRGB"))
      account_.tell("#MRGB", "has colours in the way of ZBrush, which are not read", line());
  }

  void name(ObjUse use, std::string_view rest) {
    if (use == ObjUse::libraries) files_.push_back({std::string(TextScanner(rest).rest()), line()});
    if (use != ObjUse::material) return;
    const std::string_view material = obj_name(rest);
    if (material.empty()) account_.tell("usemtl", "has no name: the faces after it have no material", line());
    part_ = part_of_(material);
  }

  void statement(const ObjWord& rule, TextScanner scan) {
    (void)scan.word();
    switch (rule.use) {
      case ObjUse::vertex:
        return vertex(scan);
      case ObjUse::uv:
        return uv(scan);
      case ObjUse::normal:
        row(scan, rows_[2], 3);
        return end(scan, "vn");
      case ObjUse::face:
        return part_ != nullptr ? face(scan) : void();
      case ObjUse::smoothing:
        return smoothing(scan.rest());
      case ObjUse::told:
        return account_.tell(rule.word, rule.why, line());
      default:
        return;
    }
  }
  // Reports words after the last one that is read to the account of what the reader ignores.
  void end(TextScanner& scan, std::string_view word) {
    if (!scan.line_ends()) account_.tell(word, "has more words than are read", line());
  }

  // `least` numbers have to be there, the others of the row are 0 if they are not.
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
      suspects_.emplace_back(static_cast<std::uint32_t>(rows.count() - 1), line());
    }
    if (!scan.line_ends()) return more_of_vertex(scan);
    if (colorless_++ == 0) colorless_line_ = line();
  }
  // Behind x y z: a weight w, a colour r g b, or a colour with alpha.
  void more_of_vertex(TextScanner& scan) {
    std::array<double, 4> more{};
    std::size_t count = 0;
    while (count < more.size() && scan.number(more[count])) ++count;
    if (count == 1 && more[0] != 1) account_.tell("v", "has a weight, which is for curves and surfaces", line());
    if (count >= 3) {
      colors_.add(rows_[0].count() - 1, more.data(), line());
    } else if (colorless_++ == 0) {
      colorless_line_ = line();
    }
    if (count == 4 && more[3] != 1) account_.tell("v", "has an alpha, which is not used", line());
    if (count == 2 || !scan.line_ends()) account_.tell("v", "has more words than are read", line());
  }
  void uv(TextScanner& scan) {
    row(scan, rows_[1], 1);
    double depth = 0;
    if (scan.number(depth) && depth != 0)
      account_.tell("vt", "has a third number, which is for solid textures", line());
    end(scan, "vt");
  }
  // Nothing is lost where one group has all faces.
  void smoothing(std::string_view group) {
    const bool off = group == "0" || group == "off";
    if (smoothing_line_ == 0 && (off || (!group_.empty() && group != group_))) smoothing_line_ = line();
    group_ = group;
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
    if (n > 3) part_->fans.push_back({part_->faces.size() / 3 - (n - 2), n - 2, line()});
    if (part_->first_line == 0) part_->first_line = line();
    if (part_->corners.size() >= kNone) lines_.fail("more than 2^32 - 2 different corners");
  }
  // "v", "v/vt", "v//vn", "v/vt/vn"; a part that is empty is missing.
  Corners::Corner corner(TextScanner& scan) {
    Corners::Corner corner = {kNone, kNone, kNone};
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
    if (row > part_->largest[kind]) part_->largest[kind] = row, part_->largest_line[kind] = line();
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

  static std::vector<double> expand(const Part& part, std::size_t kind, const std::vector<double>& rows,
                                    std::size_t width) {
    std::vector<double> values(width * part.corners.size(), std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < part.corners.size(); ++i) {
      const std::uint32_t row = part.corners[i][kind];
      if (row != kNone) std::copy_n(rows.data() + width * row, width, values.data() + width * i);
    }
    return values;
  }
  std::vector<double> expand(const Part& part, std::size_t kind, bool last) {
    std::vector<double> values = expand(part, kind, rows_[kind].values, rows_[kind].width);
    if (last) release(rows_[kind].values);
    return values;
  }

  std::string vertex_place(std::uint32_t row) const {
    const auto at = std::find_if(suspects_.begin(), suspects_.end(), [row](auto& s) { return s.first == row; });
    const std::string line = at == suspects_.end() ? "" : ":" + std::to_string(at->second);
    return path() + line + ": vertex " + std::to_string(row + std::uint64_t{1});
  }
  [[nodiscard]] std::uint64_t line() const noexcept { return lines_.number(); }

  FileBytes bytes_;
  Lines lines_;
  std::function<Part*(std::string_view)> part_of_;
  Part* part_;  // of the faces that come now; null: they are not wanted
  std::array<Rows, 3> rows_ = {Rows{"vertex", 3}, Rows{"vt", 2}, Rows{"vn", 3}};
  Colors colors_;
  std::vector<NamedFile> files_;
  std::vector<std::pair<std::uint32_t, std::uint64_t>> suspects_;  // rows of v that are not finite, and their lines
  WordAccount account_;
  std::uint64_t colorless_ = 0, colorless_line_ = 0;  // rows of v, and the first of them
  std::string group_;                                 // of smoothing
  std::uint64_t smoothing_line_ = 0;                  // where faces were first to be flat, or apart from others
  std::string joined_;
};

}  // namespace

std::string_view obj_name(std::string_view rest) noexcept {
  const auto trimmed = [](std::string_view text) { return TextScanner(text).rest(); };
  rest = trimmed(rest);
  for (std::size_t at = rest.find('#'); at < rest.size(); at = rest.find('#', at + 1)) {
    const std::string_view after = rest.substr(at + 1);
    const bool spaced = after.empty() || TextScanner(after).word_ends();
    if (at == 0 && !spaced) continue;
    if (at > 0 && !TextScanner(rest.substr(at - 1)).word_ends()) continue;
    const std::size_t digits = std::min(after.find_first_not_of("0123456789"), after.size());
    const std::string_view behind = trimmed(after.substr(digits));
    if (digits > 0 &&
        (digits == after.size() || (TextScanner(after.substr(digits)).word_ends() && behind.starts_with('#'))))
      continue;
    return trimmed(rest.substr(0, at));
  }
  return rest;
}

MeshData read_obj(const std::filesystem::path& path, const std::optional<std::string>& material) {
  Part part;
  ObjReader reader(path, [&](std::string_view name) { return !material || name == *material ? &part : nullptr; });
  reader.read();
  return reader.mesh(std::move(part), true);
}

std::vector<ObjMaterial> read_obj_by_material(const std::filesystem::path& path) {
  std::map<std::string, Part, std::less<>> parts;
  ObjReader reader(path, [&](std::string_view name) {
    const auto found = parts.find(name);
    return found != parts.end() ? &found->second : &parts[std::string(name)];
  });
  reader.read();
  std::erase_if(parts, [](const auto& part) { return part.second.faces.empty(); });
  if (parts.empty()) throw MeshError(path.string() + ": the mesh is empty: it has no faces", true);
  std::vector<std::pair<const std::string, Part>*> ordered;
  for (auto& part : parts) ordered.push_back(&part);
  std::sort(ordered.begin(), ordered.end(),
            [](const auto* a, const auto* b) { return a->second.first_line < b->second.first_line; });
  std::vector<ObjMaterial> meshes;
  WordAccount left_out;
  for (auto* part : ordered) {
    const std::uint64_t line = part->second.first_line;
    try {
      meshes.push_back({part->first, reader.mesh(std::move(part->second), part == ordered.back())});
    } catch (const MeshError& error) {
      if (!error.no_face_left() || (meshes.empty() && part == ordered.back())) throw;
      left_out.tell(part->first, "is a material without area: all its faces are degenerate", line);
    }
  }
  left_out.add_to(meshes.front().mesh.warnings);
  return meshes;
}

}  // namespace equaltime
