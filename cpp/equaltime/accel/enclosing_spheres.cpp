#include "equaltime/accel/enclosing_spheres.h"

#include <algorithm>
#include <numeric>

#include "equaltime/math/bounds.h"

namespace equaltime {

namespace {

bool holds(const Bounds& box, const Bounds& other) noexcept {
  return min(box.lo, other.lo) == box.lo && max(box.hi, other.hi) == box.hi;
}

}  // namespace

EnclosingSpheres::EnclosingSpheres(const std::vector<Sphere<float>>& spheres, const std::vector<TriangleMesh>& meshes) {
  if (spheres.empty()) return;
  Bounds smaller;  // and no wall
  for (const TriangleMesh& mesh : meshes)
    for (const Vec3f& vertex : mesh.vertices) smaller.include(Vec3d(vertex));
  std::vector<std::uint32_t> order(spheres.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return spheres[a].radius < spheres[b].radius; });
  std::vector<std::uint32_t> walls;
  for (const std::uint32_t i : order) {
    const Bounds box = box_of(spheres[i]);
    if (!smaller.empty() && holds(box, smaller))
      walls.push_back(i);
    else
      smaller.include(box);
  }
  std::sort(walls.begin(), walls.end());
  if (walls.size() % 2 == 1) walls.push_back(walls.back());
  for (std::size_t i = 0; i < walls.size(); i += 2) {
    const Sphere<float>&a = spheres[walls[i]], &b = spheres[walls[i + 1]];
    const Vec3<Lanes> center(Lanes{a.center.x, b.center.x}, Lanes{a.center.y, b.center.y},
                             Lanes{a.center.z, b.center.z});
    pairs_.push_back({center, Lanes{a.radius, b.radius}, {walls[i], walls[i + 1]}});
  }
}

}  // namespace equaltime
