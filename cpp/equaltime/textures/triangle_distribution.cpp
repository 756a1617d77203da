#include "equaltime/textures/triangle_distribution.h"

#include <algorithm>
#include <cmath>

namespace equaltime {

namespace {

/// Largest number of exact pieces: of a mesh (1 to 3 s of work), and of all meshes.
constexpr double kPieces = 0x1p24, kScenePieces = 0x1p25;
/// Largest number of points, where a triangle has more pieces than its share: a small part of a second.
constexpr double kCoarsePieces = 0x1p19;
constexpr double kFewestPieces = 16;                // of a triangle
constexpr double kCells = 0x1p20, kMostCells = 64;  // of all distributions of a scene; along a side of one
constexpr double kEven = 1.1;                       // a contrast that is not worth a distribution
constexpr double kMissed = 1e-3;                    // of what is typical, where points may miss something
constexpr int kLooks = 16;                          // along a side of the texture, for what is typical
constexpr double kWhole = 1 - 1e-9;

/// A corner of a piece: where in the triangle (how much there is of its second and third vertex), and where among the
/// texture's columns and rows.
struct Corner {
  Point2d at, cell;
};

Point2d mixed(Point2d a, Point2d b, double t) noexcept { return {std::lerp(a.x, b.x, t), std::lerp(a.y, b.y, t)}; }

double doubled_area(Point2d a, Point2d b, Point2d c) noexcept {
  return std::abs((b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y));
}

/// Pieces of one triangle of a mesh.
double pieces_each(double pieces, std::size_t triangles) noexcept {
  return std::max(kFewestPieces, pieces / static_cast<double>(triangles));
}

/// A convex polygon: a piece of a quadrilateral that four lines may have cut.
struct Polygon {
  std::array<Corner, 12> corners;
  std::size_t count = 0;

  void add(const Corner& corner) noexcept {
    if (count < corners.size()) corners[count++] = corner;
  }
};

/// Cuts off, and returns, what of a polygon is before a line across an axis of cells.
Polygon cut(Polygon& rest, double Point2d::*axis, double line) noexcept {
  Polygon before, after;
  for (std::size_t i = 0; i < rest.count; ++i) {
    const Corner &p = rest.corners[i], &q = rest.corners[i + 1 == rest.count ? 0 : i + 1];
    const double from = p.cell.*axis - line, to = q.cell.*axis - line;
    if (from <= 0) before.add(p);
    if (from >= 0) after.add(p);
    if (!((from < 0 && to > 0) || (from > 0 && to < 0))) continue;
    const double t = from / (from - to);
    Corner between{mixed(p.at, q.at, t), mixed(p.cell, q.cell, t)};
    between.cell.*axis = line;
    before.add(between), after.add(between);
  }
  rest = after;
  return before;
}

/// Calls f with the parts of a polygon between the whole numbers of an axis of cells.
template <class F>
void for_slabs(Polygon rest, double Point2d::*axis, F&& f) noexcept {
  double first = rest.corners[0].cell.*axis, last = first;
  for (std::size_t i = 1; i < rest.count; ++i) {
    first = std::min(first, rest.corners[i].cell.*axis);
    last = std::max(last, rest.corners[i].cell.*axis);
  }
  first = std::floor(first) + 1;
  for (double i = 0; i < last - first; ++i) f(cut(rest, axis, first + i));
  f(rest);
}

/// Of a function that is linear along both axes of cells, over a piece of one cell, in areas of the triangle, which
/// itself has 1/2; or as if the function were the same all over.
template <class F>
double over_piece(const Polygon& piece, bool same, F&& value) noexcept {
  if (piece.count < 3) return 0;
  double area = 0, of_cell = 0, sum = 0;
  Corner middle{};
  for (std::size_t i = 0; i < piece.count; ++i) {
    const double weight = 1 / static_cast<double>(piece.count);
    middle.at.x += piece.corners[i].at.x * weight, middle.at.y += piece.corners[i].at.y * weight;
  }
  const Corner& a = piece.corners[0];
  for (std::size_t i = 1; i + 1 < piece.count; ++i) {
    const Corner &b = piece.corners[i], &c = piece.corners[i + 1];
    area += 0.5 * doubled_area(a.at, b.at, c.at), of_cell += 0.5 * doubled_area(a.cell, b.cell, c.cell);
  }
  if (same || (piece.count == 4 && of_cell > kWhole)) return area > 0 ? area * value(middle.at) : 0;
  for (std::size_t i = 1; i + 1 < piece.count; ++i) {
    const Point2d b = piece.corners[i].at, c = piece.corners[i + 1].at;
    const double part = doubled_area(a.at, b, c) / 6;  // quadratic along its sides: exact by their middles
    if (part > 0) sum += part * (value(mixed(a.at, b, 0.5)) + value(mixed(b, c, 0.5)) + value(mixed(a.at, c, 0.5)));
  }
  return sum;
}

}  // namespace

struct MeshEmission::Footprint {
  std::array<Point2d, 3> uv, cell;  // of the corners
  double pieces;                    // about how many there are
  double lines;                     // between columns and between rows of cells that cross it
  bool steps, coarse;

  [[nodiscard]] Corner corner(double second, double third) const noexcept {
    const auto on = [&](const std::array<Point2d, 3>& p) {
      const double first = 1 - second - third;
      return Point2d{p[0].x * first + p[1].x * second + p[2].x * third,
                     p[0].y * first + p[1].y * second + p[2].y * third};
    };
    return {{second, third}, on(cell)};
  }
  [[nodiscard]] Point2f uv_at(Point2d at) const noexcept {
    const double first = 1 - at.x - at.y;
    return {static_cast<float>(uv[0].x * first + uv[1].x * at.x + uv[2].x * at.y),
            static_cast<float>(uv[0].y * first + uv[1].y * at.x + uv[2].y * at.y)};
  }
};

MeshEmission::MeshEmission(const Texture& texture, const Spectrum& color, std::size_t triangles, std::size_t meshes)
    : texture_(texture),
      color_(color),
      lattice_(std::visit([](const auto& t) { return t.lattice(); }, texture)),
      most_pieces_(pieces_each(std::min(kPieces, kScenePieces / static_cast<double>(meshes)), triangles)),
      coarse_pieces_(pieces_each(kCoarsePieces / static_cast<double>(meshes), triangles)),
      most_cells_(std::min(kMostCells, std::sqrt(kCells / static_cast<double>(triangles)))),
      typical_(0) {
  constexpr float kStep = 1.0F / kLooks;
  for (int i = 0; i < kLooks; ++i)
    for (int j = 0; j < kLooks; ++j)
      typical_ += bright({{(static_cast<float>(i) + 0.5F) * kStep, (static_cast<float>(j) + 0.5F) * kStep}});
  typical_ /= kLooks * kLooks;
}

double MeshEmission::bright(const TextureCoords& at) const noexcept {
  const Spectrum shines = color_ * eval(texture_, at);
  return static_cast<double>(Spectrum(std::abs(shines.r), std::abs(shines.g), std::abs(shines.b)).mean());
}

MeshEmission::Footprint MeshEmission::footprint(const std::array<TextureCoords, 3>& corners) const noexcept {
  Footprint f{{}, {}, 0, 0, lattice_->steps, false};
  const std::array<double, 6>& m = lattice_->from_uv;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto u = static_cast<double>(corners[i].uv.x), v = static_cast<double>(corners[i].uv.y);
    f.uv[i] = {u, v}, f.cell[i] = {m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
  }
  auto [left, right] = std::minmax({f.cell[0].x, f.cell[1].x, f.cell[2].x});
  auto [top, bottom] = std::minmax({f.cell[0].y, f.cell[1].y, f.cell[2].y});
  // Counted from a whole cell nearby, the points between the corners are exact: rounding of coordinates near 10^30
  // would part them by 10^14 cells.
  const Point2d near{std::floor(left), std::floor(top)};
  for (Point2d& cell : f.cell) cell = {cell.x - near.x, cell.y - near.y};
  left -= near.x, right -= near.x, top -= near.y, bottom -= near.y;
  f.lines = (right - left) + (bottom - top);
  f.pieces = 0.5 * doubled_area(f.cell[0], f.cell[1], f.cell[2]) + f.lines + 1;
  if (f.pieces > most_pieces_) {
    // A line may cross a whole row of the distribution's cells, and parts each of them.
    const double factor = std::max(std::sqrt(f.pieces / coarse_pieces_), f.lines * most_cells_ / coarse_pieces_);
    for (Point2d& cell : f.cell) cell = {cell.x / factor, cell.y / factor};
    f.lines /= factor;
    f.steps = f.coarse = true;
  }
  return f;
}

double MeshEmission::integral(const Footprint& f, std::size_t column, std::size_t row,
                              std::size_t cells) const noexcept {
  const auto line = [&](std::size_t i) { return static_cast<double>(i) / static_cast<double>(cells); };
  const double near = std::sqrt(line(column)), far = std::sqrt(line(column + 1));
  Polygon cell;
  const double low = line(row), high = line(row + 1);
  for (const auto& [s, along] : {std::pair{near, low}, {far, low}, {far, high}, {near, high}})
    cell.add(f.corner(1 - s, s * along));
  double sum = 0;
  const auto value = [&](Point2d at) { return bright({f.uv_at(at)}); };
  for_slabs(cell, &Point2d::y, [&](const Polygon& slab) {
    if (slab.count >= 3)
      for_slabs(slab, &Point2d::x, [&](const Polygon& piece) { sum += over_piece(piece, f.steps, value); });
  });
  return 2 * sum;
}

TriangleEmission MeshEmission::of(const std::array<TextureCoords, 3>& corners, double finest) const {
  const double of_corners = (bright(corners[0]) + bright(corners[1]) + bright(corners[2])) / 3;
  if (!lattice_) return {of_corners, nullptr};
  const Footprint f = footprint(corners);
  if (!std::isfinite(f.pieces)) return {of_corners + typical_, nullptr};
  const double missed = f.coarse ? kMissed * typical_ : 0;
  const double side = std::min({std::sqrt(f.pieces), most_cells_, finest, most_pieces_ / f.lines});
  if (!(side >= 2)) return {integral(f, 0, 0, 1) + missed, nullptr};
  const auto cells = static_cast<std::size_t>(side);
  std::vector<double> weights;
  double mean = 0;
  for (std::size_t row = 0; row < cells; ++row)
    for (std::size_t column = 0; column < cells; ++column)
      mean += weights.emplace_back(integral(f, column, row, cells));
  if (!(mean > 0)) return {missed, nullptr};
  auto distribution = std::make_shared<const ImageDistribution>(cells, std::move(weights));
  if (distribution->contrast() < kEven) distribution.reset();
  return {mean + missed, std::move(distribution)};
}

}  // namespace equaltime
