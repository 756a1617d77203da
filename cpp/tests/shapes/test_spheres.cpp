// Spheres: what is left out of their quadratic changes no bit of its answer, and walls, met one by one, are met where
// Embree's tree finds them.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "equaltime/accel/accel.h"
#include "equaltime/accel/enclosing_spheres.h"
#include "tests/check.h"
#include "tests/random_lights.h"
#include "tests/scenes.h"

namespace {

using namespace equaltime;
using random_scene::Random;

/// Every root, whatever its sign.
Optional<double> by_both_roots(const Sphere<float>& s, const RayD& ray) {
  const Vec3d oc = ray.origin - s.center, &d = ray.direction;
  const double a = length_squared(d), b = -dot(oc, d);
  const double discriminant = square(s.radius) - length_squared(oc + d * (b / a));
  if (!(discriminant >= 0)) return std::nullopt;
  const double c = (length(oc) - s.radius) * (length(oc) + s.radius);
  const double q = b + std::copysign(std::sqrt(a * discriminant), b);
  const double t0 = q != 0 ? c / q : 0.0, t1 = q / a;
  for (const double t : {std::min(t0, t1), std::max(t0, t1)})
    if (t > 0) return t < ray.t_max ? Optional(t) : std::nullopt;
  return std::nullopt;
}

/// The power twin: takes what is a little within the sphere for outside.
Optional<double> hasty(const Sphere<float>& s, const RayD& ray, double slack) {
  const Vec3d oc = ray.origin - s.center;
  if (dot(oc, ray.direction) > 0 && length_squared(oc) >= square(s.radius) * (1 - slack)) return std::nullopt;
  return by_both_roots(s, ray);
}

bool same(const Optional<double>& a, const Optional<double>& b) { return a ? b && *a == *b : !b; }

TEST("a sphere that a ray leaves behind is refused exactly where both its roots say so") {
  Random random(3);
  std::vector<Vec3d> directions;
  std::vector<double> decades;  // log-uniform
  for (int i = 0; i < 4096; ++i) directions.push_back(random.direction()), decades.push_back(random.in(0, 1));
  int refused = 0, met = 0, wrong = 0, hasty_by_rounding = 0, hasty_by_much = 0;
  for (int ball = 0; ball < 100'000; ++ball) {
    const Sphere<float> sphere{random.direction() * std::pow(10, random.in(-6, 6)), std::pow(10, random.in(-6, 6))};
    const double scale = std::pow(10, random.in(-6, 6)), depth = std::pow(10, random.in(-17, 0));
    for (int i = 0; i < 100; ++i) {
      const std::size_t k = random.engine() % 4096;
      const Vec3d& out = directions[(k + 1) % 4096];
      // A quarter anywhere, a half just off the surface or just within, a quarter on it as float32 has it.
      Vec3d origin = out * scale;
      if (i % 4 > 0) origin = sphere.center + out * (sphere.radius * (i % 2 ? 1 + depth : 1 - depth));
      if (i % 4 > 2) origin = Vec3d(Vec3f(sphere.center + out * sphere.radius));
      const double t_max = i % 3 == 0 ? 1.0 : static_cast<double>(kInfinity);
      const RayD ray(origin, directions[k] * std::pow(10.0F, static_cast<float>(6 * decades[k] - 3)), t_max);
      const auto expected = by_both_roots(sphere, ray);
      wrong += !same(intersect(sphere, ray), expected);
      hasty_by_rounding += !same(hasty(sphere, ray, 1e-12), expected);
      hasty_by_much += !same(hasty(sphere, ray, 1), expected);
      expected ? ++met : ++refused;
    }
  }
  std::printf("  %d met, %d not; twins: %d and %d wrong\n", met, refused, hasty_by_rounding, hasty_by_much);
  CHECK(wrong == 0);
  CHECK(hasty_by_rounding > 1000);
  CHECK(hasty_by_much > hasty_by_rounding);
  CHECK(met > 1'000'000 && refused > 1'000'000);
}

/// A room within balls a thousand times its size, with balls in it, a square and a disk.
Geometries room_of_balls(Random& random) {
  Geometries all;
  auto& spheres = all.of<Sphere<float>>();
  all.meshes.push_back({{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  for (const double side : {-1.0, 1.0})
    for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}})
      spheres.push_back({axis * (side * 1998), 2000});
  while (spheres.size() < 10) spheres.push_back({random.point(1.5), random.in(0.1, 0.6)});
  all.of<Disk<float>>().push_back({{0, 0, 1.5}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}});
  return all;
}

TEST("walls are met one by one where Embree's tree finds them") {
  Random random(4);
  const Geometries room = room_of_balls(random);
  Geometries with_satellite = room;  // far from all walls, so that none of them holds all that is smaller
  with_satellite.of<Sphere<float>>().push_back({{0, 0, 1e6}, 0.1});
  CHECK(!EnclosingSpheres(room.of<Sphere<float>>(), room.meshes).empty() &&
        EnclosingSpheres(with_satellite.of<Sphere<float>>(), room.meshes).empty());
  const Accel beside(room), within(with_satellite);
  Geometries ball;
  ball.of<Sphere<float>>().push_back({{0, 0, 0}, 0.1});
  const Motion far_away(scenes::swing({1e3, 0, 0}, {1e3, 9, 0}, 1));
  const Accel beside_instance(room, Intersection::robust, {ball}, {{0, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1e3F, 0, 0}}});
  const Accel beside_motion(room, Intersection::robust, {ball}, {}, {{0, far_away}});
  int walls = 0, balls = 0, others = 0, shadows = 0, different = 0;
  for (int i = 0; i < 200'000; ++i) {
    Ray ray{Vec3f(random.point(1.9)), Vec3f(random.direction())};
    const auto a = beside.closest(ray), b = within.closest(ray);
    const auto instanced = beside_instance.closest(ray), later = beside_motion.closest(ray, 0.5F);
    if (!a || !b || !instanced || !later) continue;  // through a corner, where walls meet
    for (const Hit& other : {*b, *instanced, *later})
      different += a->id.geometry != other.id.geometry || a->id.primitive != other.id.primitive ||
                   other.instance != kNotInstanced;
    (a->id.geometry != room.meshes.size() ? others : a->id.primitive < 6 ? walls : balls) += 1;
    ray.direction = Vec3f(random.point(1.9)) - ray.origin;
    ray.t_max = 1;
    const bool shadow = beside.occluded(ray);
    different += shadow != within.occluded(ray) || shadow != beside_motion.occluded(ray, 0.5F);
    shadows += shadow;
  }
  std::printf("  %d rays meet walls, %d balls, %d others; %d shadows\n", walls, balls, others, shadows);
  CHECK(different == 0);
  CHECK(walls > 10'000 && balls > 5'000 && others > 10'000 && shadows > 20'000);
}

TEST("a wall is a sphere whose box holds all that is smaller and no wall") {
  const std::vector<Sphere<float>> spheres = {{{0, 0, 0}, 9}, {{1, 0, 0}, 1}, {{0, 0, 0}, 4}, {{20, 0, 0}, 2}};
  const auto count = [&](std::size_t n) {
    const EnclosingSpheres walls({spheres.begin(), spheres.begin() + static_cast<std::ptrdiff_t>(n)}, {});
    const auto left = walls.taken_out_of(spheres);
    return std::count_if(left.begin(), left.end(), [](const auto& s) { return !(s.radius > 0); });
  };
  CHECK(count(1) == 0 && count(2) == 1 && count(3) == 2 && count(4) == 0);
}

TEST("of walls in one place the first is met") {
  Geometries all;
  auto& spheres = all.of<Sphere<float>>();
  spheres.push_back({{0, 0, 0}, 0.01});
  for (int i = 0; i < 3; ++i) spheres.push_back({{0, 0, 0}, 1});
  const Accel accel(all);
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const auto hit = accel.closest({Vec3f(random.direction() * 3), Vec3f(random.direction())});
    CHECK(!hit || hit->id.primitive < 2);
  }
}

}  // namespace

int main() { return check::run(); }
