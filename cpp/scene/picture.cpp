#include "scene/picture.h"

#include <algorithm>
#include <numeric>

namespace equaltime {

namespace {

constexpr std::size_t kFewestCells = 64, kMostCells = 1024, kMostKnots = 8192;  // along a side
constexpr std::size_t kEvenCells = 256, kPoints = 4;                            // and points along a cell's
constexpr double kSpread = 0.02;  // what each cell gets at the least, of the mean, where its points may miss something

using Lines = std::vector<double>;

Lines even_lines(std::size_t cells) {
  Lines lines;
  for (std::size_t i = 0; i <= cells; ++i) lines.push_back(static_cast<double>(i) / static_cast<double>(cells));
  return lines;
}

/// Lines with no fewer cells than are wanted between them: what is linear between two lines is so between more.
Lines refined(const Lines& knots) {
  const std::size_t cells = knots.size() - 1, parts = (kFewestCells + cells - 1) / cells;
  Lines lines{0};
  for (std::size_t i = 0; i < cells; ++i)
    for (std::size_t k = 1; k <= parts; ++k)
      lines.push_back(std::lerp(knots[i], knots[i + 1], static_cast<double>(k) / static_cast<double>(parts)));
  return lines;
}

/// Every so manieth line, and the last.
Lines thinned(const Lines& lines) {
  const std::size_t cells = lines.size() - 1, step = (cells + kMostCells - 1) / kMostCells;
  Lines kept;
  for (std::size_t i = 0; i < cells; i += step) kept.push_back(lines[i]);
  kept.push_back(1);
  return kept;
}

struct Radiance {
  const Texture& texture;
  Spectrum color;
  [[nodiscard]] double operator()(double u, double v) const noexcept {
    const Point2f uv{static_cast<float>(u), static_cast<float>(v)};
    return std::max(0.0, static_cast<double>((color * eval(texture, {uv})).mean()));
  }
};

/// The integrals over the cells between lines, of what is linear along each side of them: the mean of the corners.
std::vector<double> integrals(const Radiance& radiance, const Lines& u, const Lines& v, bool steps) {
  std::vector<double> weights;
  Lines upper(u.size()), lower(u.size());
  const auto look_along = [&](double at, Lines& row) {
    for (std::size_t i = 0; i < u.size(); ++i) row[i] = radiance(u[i], at);
  };
  if (!steps) look_along(v[0], lower);
  for (std::size_t j = 0; j + 1 < v.size(); ++j) {
    std::swap(upper, lower);
    if (!steps) look_along(v[j + 1], lower);
    for (std::size_t i = 0; i + 1 < u.size(); ++i) {
      const double mean = steps ? radiance(0.5 * (u[i] + u[i + 1]), 0.5 * (v[j] + v[j + 1]))
                                : 0.25 * (upper[i] + upper[i + 1] + lower[i] + lower[i + 1]);
      weights.push_back(mean * (u[i + 1] - u[i]) * (v[j + 1] - v[j]));
    }
  }
  return weights;
}

/// Sums over the cells between fewer lines, of which each is one of the others.
std::vector<double> joined(const std::vector<double>& weights, const Lines& u, const Lines& v, const Lines& wide_u,
                           const Lines& wide_v) {
  std::vector<double> sums((wide_u.size() - 1) * (wide_v.size() - 1), 0);
  std::size_t row = 0;
  for (std::size_t j = 0; j + 1 < v.size(); ++j) {
    if (v[j] >= wide_v[row + 1]) ++row;
    std::size_t column = 0;
    for (std::size_t i = 0; i + 1 < u.size(); ++i) {
      if (u[i] >= wide_u[column + 1]) ++column;
      sums[row * (wide_u.size() - 1) + column] += weights[j * (u.size() - 1) + i];
    }
  }
  return sums;
}

/// With what each cell gets at the least.
std::vector<double> spread(std::vector<double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double total = sum > 0 ? sum : 1;  // no point met what shines
  for (double& w : weights) w += kSpread * total / static_cast<double>(weights.size());
  return weights;
}

std::vector<double> even_weights(const Radiance& radiance) {
  std::vector<double> weights;
  constexpr double kStep = 1.0 / (kEvenCells * kPoints), kShare = kStep * kStep;
  for (std::size_t j = 0; j < kEvenCells; ++j)
    for (std::size_t i = 0; i < kEvenCells; ++i) {
      double sum = 0;
      for (std::size_t y = 0; y < kPoints; ++y)
        for (std::size_t x = 0; x < kPoints; ++x)
          sum += radiance((static_cast<double>(i * kPoints + x) + 0.5) * kStep,
                          (static_cast<double>(j * kPoints + y) + 0.5) * kStep);
      weights.push_back(sum * kShare);
    }
  return spread(std::move(weights));
}

std::size_t cell_of(const Lines& lines, double at) noexcept {
  const auto above = std::upper_bound(lines.begin() + 1, lines.end() - 1, at);
  return static_cast<std::size_t>(above - lines.begin() - 1);
}

double width(const Lines& lines, std::size_t cell) noexcept { return lines[cell + 1] - lines[cell]; }

}  // namespace

Picture::Picture(const Texture& texture, const Spectrum& color) {
  const Radiance radiance{texture, color};
  const TextureGrid grid = std::visit([](const auto& t) { return t.grid(kMostKnots); }, texture);
  if (grid.u.empty()) {
    u_ = v_ = even_lines(kEvenCells);
    set_weights(even_weights(radiance));
  } else {
    const Lines u = refined(grid.u), v = refined(grid.v);
    u_ = thinned(u), v_ = thinned(v);
    set_weights(joined(integrals(radiance, u, v, grid.steps), u, v, u_, v_));
  }
}

Picture::Picture(std::size_t cells, std::vector<double> weights) : u_(even_lines(cells)), v_(u_) {
  set_weights(spread(std::move(weights)));
}

void Picture::set_weights(std::vector<double> weights) {
  const std::size_t columns = u_.size() - 1;
  cells_ = OrderedTable2D(weights, columns);
  if (!(mean() > 0)) return;
  double squares = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    squares += weights[i] * weights[i] / (width(u_, i % columns) * width(v_, i / columns));
  contrast_ = squares / (mean() * mean());
}

Point2d Picture::sample(Point2d u) const noexcept {
  const auto [row, column] = cells_.choose(u.x, u.y);
  return {std::lerp(u_[column.index], u_[column.index + 1], column.rest),
          std::lerp(v_[row.index], v_[row.index + 1], row.rest)};
}

double Picture::density(double u, double v) const noexcept {
  const std::size_t column = cell_of(u_, u), row = cell_of(v_, v);
  return cells_.pmf(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column)) /
         (width(u_, column) * width(v_, row));
}

std::size_t Picture::memory_bytes() const noexcept {
  return sizeof(*this) + (u_.size() + v_.size()) * sizeof(double) + cells_.memory_bytes();
}

}  // namespace equaltime
