// Threads of a build: no more than are asked for, and one scene whatever their number. A program of its own, because
// oneTBB keeps the threads that it has started.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <thread>

#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace scenes;

long threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), std::filesystem::directory_iterator());
}

/// Sides of the hills, so many that every thread that may build has work.
constexpr std::uint32_t kSide = 300;

/// The full room over hills of 180000 triangles.
SceneDescription hills() {
  SceneDescription d = full_room();
  MeshDescription mesh;
  for (std::uint32_t i = 0; i <= kSide; ++i)
    for (std::uint32_t j = 0; j <= kSide; ++j) {
      const double x = 0.01 * i, z = 0.01 * j;
      mesh.vertices.push_back({x - 1.5, 0.03125 * std::sin(9 * x) * std::cos(7 * z), z - 1.5});
    }
  for (std::uint32_t i = 0; i < kSide; ++i)
    for (std::uint32_t j = 0; j < kSide; ++j) {
      const std::uint32_t a = i * (kSide + 1) + j, b = a + kSide + 1;
      mesh.triangles.push_back({a, a + 1, b});
      mesh.triangles.push_back({b, a + 1, b + 1});
    }
  mesh.surface = {.front = 0, .back = 0};
  d.shapes.emplace_back(std::move(mesh));
  return d;
}

Moments seen(unsigned threads) {
  Settings shallow;
  shallow.max_depth = 4;
  const auto scene = std::make_shared<const Scene>(build_scene(hills(), {.threads = threads}));
  return rendered(scene, 2, shallow, {.seed = 5, .threads = 1});
}

TEST("one thread builds alone; the image does not depend on how many build") {
  const Moments alone = seen(1);
  CHECK(threads_of_this_process() == 1);
  const Moments by_three = seen(3);
  CHECK(threads_of_this_process() > 1 && threads_of_this_process() <= 3);
  CHECK(mean(alone) > 0);
  CHECK(same_bits(alone, by_three) && same_bits(alone, seen(0)));
}

TEST("the error of a build on threads is the caller's") {
  SceneDescription d = hills();
  std::get<SphereDescription>(d.shapes[4]).radius = -1;
  CHECK_THROWS(std::invalid_argument, "shape 4 (sphere): a sphere needs", build_scene(d, {.threads = 2}));
}

}  // namespace

int main() { return check::run(); }
