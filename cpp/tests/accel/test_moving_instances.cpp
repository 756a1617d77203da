// Moving instances: a few, met one by one, are met where those of a crowd are found in Embree's tree.
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "equaltime/accel/accel.h"
#include "tests/check.h"
#include "tests/random_lights.h"
#include "tests/scenes.h"

namespace {

using namespace equaltime;
using random_scene::Random;

/// A floor; and to be moved, a wedge that is open behind, and two balls.
Geometries floor_of_two() { return {{{{{-3, -1, -3}, {3, -1, -3}, {0, -1, 4}}, {{0, 1, 2}}}}}; }
std::vector<Geometries> wedge_and_balls() {
  Geometries wedge, balls;
  wedge.meshes.push_back({{{0, -1, 0}, {0, 1, 0}, {1, -1, 1}, {1, 1, 1}, {-1, -1, 1}, {-1, 1, 1}},
                          {{0, 1, 2}, {1, 2, 3}, {0, 1, 4}, {1, 4, 5}}});
  balls.of<Sphere<float>>() = {{{0.25, 0, 0}, 0.5}, {{-0.5, 0.25, 0}, 0.375}};
  return {wedge, balls};
}

/// Two that swing, and as many as are asked for that swing far away.
std::vector<MovingInstanceGeometry> swinging(std::uint32_t far_away) {
  std::vector<MovingInstanceGeometry> all;
  for (std::uint32_t i = 0; i < 2; ++i) {
    const double x = 1.5 * i - 1;
    all.push_back({i % 2, Motion(scenes::swing({x, 0, -1}, {-x, 0.5, 1.5}, 0.5 + 0.25 * i))});
  }
  for (std::uint32_t i = 0; i < far_away; ++i)
    all.push_back({0, Motion(scenes::swing({1e3, 0, 0}, {1e3, 9, 9.0 * i}, 1))});
  return all;
}

bool same(const Optional<Hit>& a, const Optional<Hit>& b) {
  if (!a || !b) return !a && !b;
  return a->instance == b->instance && a->id.geometry == b->id.geometry && a->id.primitive == b->id.primitive;
}

TEST("a placement does not depend on the placements that were asked for before") {
  const auto moving_to = [](double x) {
    Transform begin = scenes::placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}), end = begin;
    end.m[0][3] = x;
    return Motion({{0, begin}, {1, end}});
  };
  std::vector<Motion> motions;
  for (int i = 0; i < 40; ++i) {
    motions.push_back(moving_to(i + 1));
    motions.push_back(motions.back().between({{0, 0, 0}, 1}, {{0, 0, 0}, 4}));  // where lengths are four times as large
  }
  const std::vector<Motion> copies = motions;
  int wrong = 0;
  for (int turn = 0; turn < 4; ++turn)
    for (const double time : {0.25, 0.5, 0.25})
      for (std::size_t i = 0; i < motions.size(); ++i)
        for (const Motion* motion : {&std::as_const(motions[i]), &copies[i]}) {
          const double x = static_cast<double>(i / 2 + 1) * time * (i % 2 == 0 ? 1 : 4);
          wrong += std::abs(motion->at(time).origin.x - x) > 1e-12;
        }
  CHECK(wrong == 0);
}

TEST("a few moving instances are met one by one where Embree's tree finds them") {
  const Accel few(floor_of_two(), Intersection::robust, wedge_and_balls(), {}, swinging(0));
  const Accel many(floor_of_two(), Intersection::robust, wedge_and_balls(), {}, swinging(20));
  Random random(6);
  int moving = 0, still = 0, shadows = 0, different = 0, different_later = 0;
  for (int i = 0; i < 200'000; ++i) {
    const float time = i % 3 ? static_cast<float>(random.in(0, 1)) : static_cast<float>(i % 2);
    Ray ray{Vec3f(random.point(2)), Vec3f(random.direction())};
    if (i % 5 == 0) ray.direction = i % 2 ? Vec3f{0, -1, 0} : Vec3f{-0.0F, 0, 1};
    const auto hit = few.closest(ray, time);
    different += !same(hit, many.closest(ray, time));
    different_later += !same(hit, many.closest(ray, 1 - time));
    if (hit) ++(hit->instance == kNotInstanced ? still : moving);
    ray.direction = Vec3f(random.point(2)) - ray.origin;
    ray.t_max = 1;
    const bool shadow = few.occluded(ray, time);
    different += shadow != many.occluded(ray, time);
    shadows += shadow;
  }
  std::printf("  %d rays meet what moves, %d what does not; %d shadows; at other times %d differ\n", moving, still,
              shadows, different_later);
  CHECK(different == 0);
  CHECK(moving > 5'000 && still > 10'000 && shadows > 20'000 && different_later > 5'000);
}

}  // namespace

int main() { return check::run(); }
