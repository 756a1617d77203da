#include "equaltime/shapes/winding.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// Of a closed mesh, the vector areas of all triangles add up to nothing, and its winding numbers are whole.
constexpr double kClosed = 1e-5, kWhole = 1e-3;

std::array<Vec3f, 3> corners_of(const TriangleMesh& mesh, std::uint32_t triangle, float time) noexcept {
  if (!mesh.later.empty()) return corners_at(mesh, triangle, time);
  const auto& [i, j, k] = mesh.triangles[triangle];
  return {mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]};
}

double signed_volume(const TriangleMesh& mesh, const Vec3d& from, float time) noexcept {
  double six_volumes = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3f, 3> corners = corners_of(mesh, t, time);
    const Vec3d a = Vec3d(corners[0]) - from, b = Vec3d(corners[1]) - from, c = Vec3d(corners[2]) - from;
    six_volumes += dot(a, cross(b, c));
  }
  return six_volumes / 6;
}

/// The box around a triangle at all times.
Bounds box_of(const TriangleMesh& mesh, const Triangle& triangle) noexcept {
  Bounds box;
  for (const std::uint32_t i : triangle) {
    box.include(Vec3d(mesh.vertices[i]));
    for (const std::vector<Vec3f>& later : mesh.later) box.include(Vec3d(later[i]));
  }
  if (mesh.later.empty()) return box;
  const double rounding = 4 * static_cast<double>(kUnitRoundoff) * max_component(max(abs(box.lo), abs(box.hi)));
  const Vec3d slack{rounding, rounding, rounding};  // of vertices between two times
  return {box.lo - slack, box.hi + slack};
}

constexpr double Vec3d::*kAxes[] = {&Vec3d::x, &Vec3d::y, &Vec3d::z};

/// Along which axis lines cross the fewest triangles: for its length, where the least area is seen.
std::size_t best_axis(const TriangleMesh& mesh, const Bounds& box) noexcept {
  Vec3d seen{};
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3d a(mesh.vertices[i]);
    seen = seen + abs(cross(Vec3d(mesh.vertices[j]) - a, Vec3d(mesh.vertices[k]) - a));
  }
  const Vec3d e = box.extent();
  const double layers[] = {seen.x / (e.y * e.z), seen.y / (e.z * e.x), seen.z / (e.x * e.y)};
  return static_cast<std::size_t>(std::min_element(layers, layers + 3) - layers);
}

/// How an edge turns round the origin of the plane across an axis: 1 if it crosses the half line from there along the
/// first coordinate upwards, -1 downwards. The same edge the other way round gives exactly the opposite.
int crossing(const Vec3d& from, const Vec3d& to, std::size_t axis) noexcept {
  const auto x = kAxes[(axis + 1) % 3], y = kAxes[(axis + 2) % 3];
  const bool upwards = to.*y > 0;
  if ((from.*y > 0) == upwards) return 0;
  const Vec3d &lower = upwards ? from : to, &upper = upwards ? to : from;
  if (!(lower.*x * upper.*y > lower.*y * upper.*x)) return 0;
  return upwards ? 1 : -1;
}

}  // namespace

std::optional<Enclosure> enclosure(const TriangleMesh& mesh, const Vec3d& point, float time) noexcept {
  Vec3d vector_area{};
  double area = 0, volume = 0, angle = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<Vec3f, 3> corners = corners_of(mesh, t, time);
    const Vec3d a = Vec3d(corners[0]) - point, b = Vec3d(corners[1]) - point, c = Vec3d(corners[2]) - point;
    const Vec3d twice = cross(b - a, c - a);
    const double la = length(a), lb = length(b), lc = length(c), determinant = dot(a, cross(b, c));
    vector_area = vector_area + twice;
    area += length(twice);
    volume += determinant;
    angle += 2 * elementary::atan2(determinant, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  const double turns = angle * std::numbers::inv_pi / 4, whole = std::round(turns);
  if (!(length(vector_area) <= kClosed * area) || !(std::abs(turns - whole) < kWhole)) return std::nullopt;
  return Enclosure{whole > 0 || (whole == 0 && volume < 0), std::abs(volume) / 6};
}

Enclosure enclosure(const Sphere<float>& sphere, bool flipped, const Vec3d& point) noexcept {
  const bool inside = length(point - sphere.center) < sphere.radius;
  return {inside != flipped, 4.0 / 3.0 * std::numbers::pi * sphere.radius * sphere.radius * sphere.radius};
}

ClosedMesh::ClosedMesh(const TriangleMesh& mesh, const Bounds& box) : mesh_(&mesh), box_(box) {
  const std::size_t samples = 3 * mesh.later.size();
  for (std::size_t i = 0; i <= samples; ++i) {
    const float time = samples > 0 ? static_cast<float>(static_cast<double>(i) / static_cast<double>(samples)) : 0.0F;
    volumes_.push_back(signed_volume(mesh, box.center(), time));
  }
  // From outside, only what is inside out matters, and only if it is closed.
  if (std::ranges::any_of(volumes_, [](double v) { return v < 0; })) closed_ = closed_from_outside();
}

void ClosedMesh::prepare() {
  if (tree_.memory_bytes() > 0 || !closed_) return;
  closed_ = closed_from_outside();
  if (!closed_) return;
  axis_ = best_axis(*mesh_, box_);
  std::vector<Bounds> boxes;
  boxes.reserve(mesh_->triangles.size());
  for (const Triangle& triangle : mesh_->triangles) boxes.push_back(box_of(*mesh_, triangle));
  tree_ = BoxTree(boxes);
}

/// From a place that no symmetry of the mesh distinguishes, so that what holes leave out does not cancel.
bool ClosedMesh::closed_from_outside() const noexcept {
  const Vec3d e = box_.extent(), place = box_.hi + Vec3d{0.137 * e.x, 0.211 * e.y, 0.173 * e.z};
  const std::size_t parts = mesh_->later.size();
  for (std::size_t i = 0; i <= parts; ++i) {
    const float time = parts > 0 ? static_cast<float>(i) / static_cast<float>(parts) : 0.0F;
    if (!equaltime::enclosure(*mesh_, place, time)) return false;
  }
  return true;
}

/// Between two times at which vertices are given they move evenly, so that the volume is a cubic polynomial.
double ClosedMesh::volume(float time) const noexcept {
  if (volumes_.size() == 1) return volumes_[0];
  const auto [part, fraction] = between(time, volumes_.size() / 3);
  const double* v = &volumes_[3 * part];
  const double x = 3 * fraction, a = x - 1, b = x - 2, c = x - 3;
  return (-v[0] * a * b * c + 3 * v[1] * x * b * c - 3 * v[2] * x * a * c + v[3] * x * a * b) / 6;
}

std::optional<int> ClosedMesh::winding(const Vec3d& point, float time) const noexcept {
  int before = 0, whole = 0;
  bool on_surface = false;
  Bounds line{point, point};
  line.lo.*kAxes[axis_] = box_.lo.*kAxes[axis_], line.hi.*kAxes[axis_] = box_.hi.*kAxes[axis_];
  tree_.each_touching(line, [&](std::uint32_t triangle) {
    const std::array<Vec3f, 3> corners = corners_of(*mesh_, triangle, time);
    const Vec3d a = Vec3d(corners[0]) - point, b = Vec3d(corners[1]) - point, c = Vec3d(corners[2]) - point;
    const int turn = crossing(a, b, axis_) + crossing(b, c, axis_) + crossing(c, a, axis_);
    const double determinant = dot(a, cross(b, c));
    whole += turn;
    if (determinant * turn > 0) before += turn;
    on_surface = on_surface || (determinant == 0 && touch(box_of(*mesh_, mesh_->triangles[triangle]), {point, point}));
    return true;
  });
  if (on_surface || whole != 0) return std::nullopt;
  return before;
}

std::optional<Enclosure> ClosedMesh::enclosure(const Vec3d& point, float time) const noexcept {
  if (!closed_) return std::nullopt;
  const double v = volume(time);
  int turns = 0;
  if (touch(box_, {point, point})) {
    const std::optional<int> counted = winding(point, time);
    if (!counted) return equaltime::enclosure(*mesh_, point, time);
    turns = *counted;
  }
  return Enclosure{turns > 0 || (turns == 0 && v < 0), std::abs(v)};
}

}  // namespace equaltime
