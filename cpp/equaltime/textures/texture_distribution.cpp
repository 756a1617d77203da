#include "equaltime/textures/texture_distribution.h"

#include <algorithm>
#include <cmath>

namespace equaltime {

namespace {

constexpr std::size_t kFewestCells = 64, kMostCells = 1024, kMostKnots = 8192;  // along a side
constexpr std::size_t kEvenCells = 256, kPoints = 4;                            // and points along a cell's

using Lines = std::vector<double>;

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
  return weights;
}

}  // namespace

ImageDistribution picture_of(const Texture& texture, const Spectrum& color) {
  const Radiance radiance{texture, color};
  const TextureGrid grid = std::visit([](const auto& t) { return t.grid(kMostKnots); }, texture);
  if (grid.u.empty()) return {kEvenCells, even_weights(radiance)};
  const Lines u = refined(grid.u), v = refined(grid.v), wide_u = thinned(u), wide_v = thinned(v);
  return {wide_u, wide_v, joined(integrals(radiance, u, v, grid.steps), u, v, wide_u, wide_v)};
}

}  // namespace equaltime
