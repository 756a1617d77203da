#include "accel/walls.h"

#include <algorithm>
#include <numeric>

#include "math/bounds.h"

namespace equaltime {

namespace {

Bounds box_of(const SphereGeometry& s) noexcept {
  const Vec3d half{s.radius, s.radius, s.radius};
  return {s.center - half, s.center + half};
}

bool holds(const Bounds& box, const Bounds& other) noexcept {
  return min(box.lo, other.lo) == box.lo && max(box.hi, other.hi) == box.hi;
}

}  // namespace

Walls::Walls(const std::vector<SphereGeometry>& spheres, const std::vector<TriangleMesh>& meshes) {
  if (spheres.empty()) return;
  Bounds smaller;  // and no wall
  for (const TriangleMesh& mesh : meshes)
    for (const Vec3f& vertex : mesh.vertices) smaller.include(Vec3d(vertex));
  std::vector<std::uint32_t> order(spheres.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return spheres[a].radius < spheres[b].radius; });
  for (const std::uint32_t i : order) {
    const Bounds box = box_of(spheres[i]);
    if (!smaller.empty() && holds(box, smaller))
      walls_.push_back({spheres[i], i});
    else
      smaller.include(box);
  }
  std::sort(walls_.begin(), walls_.end(), [](const Wall& a, const Wall& b) { return a.number < b.number; });
}

}  // namespace equaltime
