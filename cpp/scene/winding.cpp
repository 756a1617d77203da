#include "scene/winding.h"

#include <cmath>
#include <numbers>

#include "scene/deforming_mesh.h"

namespace equaltime {

namespace {

/// Of a closed mesh, the vector areas of all triangles add up to nothing, and its winding numbers are whole.
constexpr double kClosed = 1e-5, kWhole = 1e-3;

}  // namespace

std::optional<Enclosure> enclosure(const TriangleMesh& mesh, const Vec3d& point, float time) noexcept {
  const DeformingMesh deforming{&mesh, nullptr};
  Vec3d vector_area{};
  double area = 0, volume = 0, angle = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    const std::array<Vec3f, 3> corners = mesh.later.empty()
                                             ? std::array{mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]}
                                             : deforming.corners(t, time);
    const Vec3d a = Vec3d(corners[0]) - point, b = Vec3d(corners[1]) - point, c = Vec3d(corners[2]) - point;
    const Vec3d twice = cross(b - a, c - a);
    const double la = length(a), lb = length(b), lc = length(c), determinant = dot(a, cross(b, c));
    vector_area = vector_area + twice;
    area += length(twice);
    volume += determinant;
    angle += 2 * std::atan2(determinant, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  const double turns = angle * std::numbers::inv_pi / 4, whole = std::round(turns);
  if (!(length(vector_area) <= kClosed * area) || !(std::abs(turns - whole) < kWhole)) return std::nullopt;
  return Enclosure{whole > 0 || (whole == 0 && volume < 0), std::abs(volume) / 6};
}

Enclosure enclosure(const SphereGeometry& sphere, bool flipped, const Vec3d& point) noexcept {
  const bool inside = length(point - sphere.center) < sphere.radius;
  return {inside != flipped, 4.0 / 3.0 * std::numbers::pi * sphere.radius * sphere.radius * sphere.radius};
}

}  // namespace equaltime
