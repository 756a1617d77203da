#include "equaltime/sampling/image_distribution.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace equaltime {

namespace {

constexpr double kSpread = 0.02;  // what each cell gets at the least, of the mean, where its points may miss something

using Lines = std::vector<double>;

Lines even_lines(std::size_t cells) {
  Lines lines;
  for (std::size_t i = 0; i <= cells; ++i) lines.push_back(static_cast<double>(i) / static_cast<double>(cells));
  return lines;
}

/// With what each cell gets at the least.
std::vector<double> spread(std::vector<double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double total = sum > 0 ? sum : 1;  // no point met what shines
  for (double& w : weights) w += kSpread * total / static_cast<double>(weights.size());
  return weights;
}

std::size_t cell_of(const Lines& lines, double at) noexcept {
  const auto above = std::upper_bound(lines.begin() + 1, lines.end() - 1, at);
  return static_cast<std::size_t>(above - lines.begin() - 1);
}

double width(const Lines& lines, std::size_t cell) noexcept { return lines[cell + 1] - lines[cell]; }

}  // namespace

ImageDistribution::ImageDistribution(std::vector<double> u, std::vector<double> v, std::vector<double> weights)
    : u_(std::move(u)), v_(std::move(v)) {
  set_weights(std::move(weights));
}

ImageDistribution::ImageDistribution(std::size_t cells, std::vector<double> weights) : u_(even_lines(cells)), v_(u_) {
  set_weights(spread(std::move(weights)));
}

void ImageDistribution::set_weights(std::vector<double> weights) {
  const std::size_t columns = u_.size() - 1;
  cells_ = PiecewiseConstant2D(weights, columns);
  if (!(mean() > 0)) return;
  double squares = 0;
  for (std::size_t i = 0; i < weights.size(); ++i)
    squares += weights[i] * weights[i] / (width(u_, i % columns) * width(v_, i / columns));
  contrast_ = squares / (mean() * mean());
}

Point2d ImageDistribution::sample(Point2d u) const noexcept {
  const auto [row, column] = cells_.choose(u.x, u.y);
  return {std::lerp(u_[column.index], u_[column.index + 1], column.rest),
          std::lerp(v_[row.index], v_[row.index + 1], row.rest)};
}

double ImageDistribution::density(double u, double v) const noexcept {
  const std::size_t column = cell_of(u_, u), row = cell_of(v_, v);
  return cells_.pmf(static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(column)) /
         (width(u_, column) * width(v_, row));
}

std::size_t ImageDistribution::memory_bytes() const noexcept {
  return sizeof(*this) + (u_.size() + v_.size()) * sizeof(double) + cells_.memory_bytes();
}

}  // namespace equaltime
