// Packets: many rays at once meet what each of them meets alone.
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "equaltime/accel/accel.h"
#include "tests/check.h"
#include "tests/random_lights.h"
#include "tests/scenes.h"

namespace {

using namespace equaltime;
using random_scene::Random;

/// Triangles, some of them slivers, and what is met by calls back: spheres, disks and cylinders.
Geometries all_kinds(Random& random) {
  Geometries all;
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 60; ++i) {
    const Vec3d p = random.point(2), q = p + random.direction();
    const double wide = i % 4 == 0 ? 1e-7 : 0.5;
    mesh.vertices.insert(mesh.vertices.end(), {Vec3f(p), Vec3f(q), Vec3f((p + q) * 0.5 + random.direction() * wide)});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  all.meshes.push_back(std::move(mesh));
  for (int i = 0; i < 20; ++i) all.of<Sphere<float>>().push_back({random.point(2), random.in(0.05, 0.2)});
  all.of<Disk<float>>().push_back({{0, 0, 1.5}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}});
  all.of<Cylinder<float>>().push_back({{-1, -1, -1}, {0, 0, 1}, 2, 0.3});
  return all;
}

struct Rays {
  std::vector<Ray> rays;
  std::vector<float> times;

  Rays(Random& random, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const float t_max = i % 3 == 0 ? 1.0F : kInfinity;
      rays.push_back({Vec3f(random.point(2)), Vec3f(random.direction()), t_max});
      times.push_back(static_cast<float>(random.in(0, 1)));
    }
  }
};

bool same(const Optional<Hit>& a, const Optional<Hit>& b) {
  if (!a || !b) return !a && !b;
  return a->instance == b->instance && a->id.geometry == b->id.geometry && a->id.primitive == b->id.primitive;
}

void check_packets(const char* what, const Accel& accel, Random& random) {
  int met = 0, dark = 0, different = 0;
  for (const std::size_t count : {0U, 1U, 7U, 8U, 9U, 20'000U}) {
    const Rays some(random, count);
    std::vector<Optional<Hit>> hits(count);
    const auto blocked = std::make_unique<bool[]>(count);
    accel.closest(some.rays, some.times, hits);
    accel.occluded(some.rays, some.times, {blocked.get(), count});
    for (std::size_t i = 0; i < count; ++i) {
      different += !same(hits[i], accel.closest(some.rays[i], some.times[i]));
      different += blocked[i] != accel.occluded(some.rays[i], some.times[i]);
      met += hits[i].has_value(), dark += blocked[i];
    }
  }
  std::printf("  %s: %d rays meet something, %d are blocked, %d differ\n", what, met, dark, different);
  CHECK(different == 0 && met > 3'000 && met < 20'000 && dark == met);
}

TEST("packets meet what single rays meet: fixed, in instances, and moving") {
  Random random(8);
  const Geometries own = all_kinds(random), group = all_kinds(random);
  check_packets("fixed", Accel(own), random);
  const InstanceGeometry beside{0, {1, 0, 0, 0, 0, 1, 0, -1, 0, 0.5F, 0, 0}};
  check_packets("an instance", Accel(own, Intersection::robust, {group}, {beside}), random);
  for (const std::size_t count : {1U, 4U}) {  // a few, and a crowd
    std::vector<MovingInstanceGeometry> moving;
    for (std::size_t i = 0; i < count; ++i)
      moving.push_back({0, Motion(scenes::swing({0, 0, 0}, {1, 0.5, static_cast<double>(i)}, 1))});
    check_packets("moving", Accel(own, Intersection::robust, {group}, {beside}, moving), random);
  }
}

TEST("packets refuse the rays that Embree does not take, and trace the others") {
  Random random(9);
  const Accel accel(all_kinds(random));
  Rays some(random, 8);
  some.rays[3].origin.x = std::nanf("");
  std::vector<Optional<Hit>> hits(8);
  static_cast<void>(Accel::take_refusal());
  accel.closest(some.rays, some.times, hits);
  CHECK(Accel::take_refusal() && !hits[3]);
  for (std::size_t i = 0; i < 8; ++i) CHECK(i == 3 || same(hits[i], accel.closest(some.rays[i], some.times[i])));
}

}  // namespace

int main() { return check::run(); }
