#include "equaltime/scene/instance.h"

namespace equaltime {

namespace {

constexpr double kRounding = static_cast<double>(kUnitRoundoff);

Vec3d to_vec(const std::array<float, 12>& m, std::size_t column) noexcept {
  return Vec3d(Vec3f(m[3 * column], m[3 * column + 1], m[3 * column + 2]));
}
Vec3d combined(const Vec3d (&rows)[3], const Vec3d& v) noexcept {
  return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)};
}
/// |a|×|b| with all terms added, so that none cancels another.
Vec3d cross_of_sizes(const Vec3d& a, const Vec3d& b) noexcept {
  const Vec3d x = abs(a), y = abs(b);
  return {x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x};
}

}  // namespace

/// Embree inverts the matrix in float32 by cofactors. Each is a difference of two products, the determinant a sum of
/// such, and its reciprocal good to about two units; then come the products and sums of the transform itself, of the
/// point and of the origin apart.
Instance::Instance(const InstanceGeometry& geometry) noexcept
    : group_(geometry.group),
      columns_{to_vec(geometry.to_world, 0), to_vec(geometry.to_world, 1), to_vec(geometry.to_world, 2)},
      origin_(to_vec(geometry.to_world, 3)) {
  double determinant = dot(columns_[0], cross(columns_[1], columns_[2]));
  const double size = dot(abs(columns_[0]), cross_of_sizes(columns_[1], columns_[2]));
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d &a = columns_[(i + 1) % 3], &b = columns_[(i + 2) % 3];
    rows_[i] = cross(a, b) / determinant;
    const double of_determinant = 4 * size / std::abs(determinant) + 4;
    error_[i] = (cross_of_sizes(a, b) * (3 / std::abs(determinant)) + abs(rows_[i]) * (of_determinant + 4)) * kRounding;
  }
}

/// The same error terms in float64, eight units each, and the rounding of the ray to float32.
Instance::Instance(std::uint32_t group, const AffineMap& now) noexcept
    : group_(group),
      columns_{now.columns[0], now.columns[1], now.columns[2]},
      origin_(now.origin),
      rows_{now.rows[0], now.rows[1], now.rows[2]} {
  constexpr double kExact = 0x1p-50;
  const double inverse = std::abs(1 / dot(columns_[0], cross(columns_[1], columns_[2])));
  const double cancelled = dot(abs(columns_[0]), cross_of_sizes(columns_[1], columns_[2])) * inverse;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d sizes = cross_of_sizes(columns_[(i + 1) % 3], columns_[(i + 2) % 3]);
    error_[i] = sizes * (kExact * inverse) + abs(rows_[i]) * (kExact * cancelled + 4 * kRounding);
  }
}

RayD Instance::to_local(const RayD& ray) const noexcept {
  return {combined(rows_, ray.origin - origin_), combined(rows_, ray.direction), ray.t_max};
}

Vec3f Instance::to_world(const Vec3f& v) const noexcept {
  const Vec3d d(v);
  return Vec3f(columns_[0] * d.x + columns_[1] * d.y + columns_[2] * d.z);
}

double Instance::magnification() const noexcept { return std::abs(dot(columns_[0], cross(columns_[1], columns_[2]))); }

float Instance::position_error(const Vec3f& p, const Vec3f& normal) const noexcept {
  const Vec3d n(normal), local{dot(columns_[0], n), dot(columns_[1], n), dot(columns_[2], n)};
  const Vec3d back = rows_[0] * local.x + rows_[1] * local.y + rows_[2] * local.z;
  return static_cast<float>(dot(abs(local), combined(error_, abs(Vec3d(p)) + abs(origin_))) / length(back));
}

Bounds Instance::placed(const Bounds& local) const noexcept {
  const Vec3d half = local.extent() * 0.5, c = local.center();
  const Vec3d center = origin_ + columns_[0] * c.x + columns_[1] * c.y + columns_[2] * c.z;
  const Vec3d reach = abs(columns_[0]) * half.x + abs(columns_[1]) * half.y + abs(columns_[2]) * half.z;
  return {center - reach, center + reach};
}

detail::SurfacePoint Instance::placed(const detail::SurfacePoint& local) const noexcept {
  const auto to_world = [&](const Vec3d& v) { return columns_[0] * v.x + columns_[1] * v.y + columns_[2] * v.z; };
  // Normals go by the transposed inverse: its columns are rows_.
  const auto normal = [&](const Vec3d& v) { return rows_[0] * v.x + rows_[1] * v.y + rows_[2] * v.z; };
  detail::SurfacePoint point = local;
  ShapeHit<float>& hit = point.hit;
  hit.p = origin_ + to_world(local.hit.p);
  const Vec3d n = normal(local.hit.n);
  const double stretch = length(n);  // local distances from the plane are as many times as large
  hit.n = n / stretch;
  const Vec3d off = combined(error_, abs(hit.p) + abs(origin_));
  const double local_offset = static_cast<double>(local.hit.offset) + dot(abs(local.hit.n), off);
  hit.offset =
      static_cast<float>(local_offset / stretch * (1 + 4 * kRounding)) + point_offset(Vec3f(hit.p), Vec3f(hit.n));
  point.shading_normal = local.smooth ? Vec3f(normalize(normal(Vec3d(local.shading_normal)))) : Vec3f(hit.n);
  point.tangent = Vec3f(to_world(Vec3d(local.tangent)));
  return point;
}

}  // namespace equaltime
