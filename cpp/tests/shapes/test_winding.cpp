// Whether points are in closed meshes: by a line through each, as by all triangles; boxes that touch; and what building
// a scene keeps of its description.
#include "tests/check.h"

#include <cmath>
#include <ctime>
#include <numbers>
#include <random>
#include <set>

#include "equaltime/build/build_meshes.h"
#include "equaltime/build/normalize.h"
#include "equaltime/math/box_tree.h"
#include "equaltime/shapes/winding.h"

namespace {

using namespace equaltime;

constexpr double kTurn = 2 * std::numbers::pi;

/// A tube bent to a ring, which is no ball: lines cross it up to four times.
TriangleMesh ring(std::uint32_t around, std::uint32_t along, float size = 1) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < along; ++j) {
      const double a = kTurn * i / around, b = kTurn * j / along, r = 2 + std::cos(b);
      mesh.vertices.push_back(Vec3f(Vec3d{r * std::cos(a), r * std::sin(a), std::sin(b)}) * size);
    }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return i % around * along + j % along; };
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < along; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

Bounds box_of(const TriangleMesh& mesh) {
  Bounds box;
  for (const Vec3f& v : mesh.vertices) box.include(Vec3d(v));
  for (const auto& later : mesh.later)
    for (const Vec3f& v : later) box.include(Vec3d(v));
  return box;
}

ClosedMesh prepared(const TriangleMesh& mesh) {
  ClosedMesh closed(mesh, box_of(mesh));
  closed.prepare();
  return closed;
}

bool agree(const std::optional<Enclosure>& a, const std::optional<Enclosure>& b) {
  if (!a || !b) return !a && !b;
  return a->behind == b->behind && std::abs(a->volume - b->volume) <= 1e-6 * b->volume;
}

/// At places all round, some of which lie in the planes and on the lines of what is even.
void check_everywhere(const TriangleMesh& mesh, float time) {
  const ClosedMesh closed = prepared(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-3.5, 3.5);
  int inside = 0;
  for (int i = 0; i < 2000; ++i) {
    Vec3d p{place(random), place(random), 0.4 * place(random)};
    if (i % 4 == 1) p.x = 0;
    if (i % 4 == 2) p.x = p.y = 0;
    if (i % 4 == 3) p.z = 0;
    const std::optional<Enclosure> found = closed.enclosure(p, time), expected = enclosure(mesh, p, time);
    CHECK(agree(found, expected));
    inside += expected && expected->behind ? 1 : 0;
  }
  CHECK(inside > 100 && inside < 1900);
}

void turn_inside_out(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

double seconds_of_points(const TriangleMesh& mesh) {
  const ClosedMesh closed = prepared(mesh);
  const std::clock_t begin = std::clock();
  int inside = 0;
  for (int i = 0; i < 20000; ++i) inside += closed.enclosure({2.0 + i * 1e-5, i * 3e-5, 0.1}, 0)->behind ? 1 : 0;
  CHECK(inside > 0);
  return static_cast<double>(std::clock() - begin);
}

}  // namespace

TEST("a line tells whether a point is in a closed mesh as all triangles do") {
  TriangleMesh mesh = ring(40, 24);
  check_everywhere(mesh, 0);
  turn_inside_out(mesh);
  check_everywhere(mesh, 0);
}

TEST("the same in a mesh that deforms, at any time") {
  TriangleMesh mesh = ring(20, 16);
  mesh.later = {ring(20, 16, 1.2F).vertices, ring(20, 16, 0.8F).vertices};
  for (const float time : {0.0F, 0.3F, 0.5F, 0.9F, 1.0F}) check_everywhere(mesh, time);
}

TEST("the sides of an axis-aligned cube are neither in it nor out of it, as by all triangles") {
  TriangleMesh cube;
  for (int i = 0; i < 8; ++i)
    cube.vertices.push_back({static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1), static_cast<float>(i >> 2)});
  cube.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const ClosedMesh closed = prepared(cube);
  for (const double x : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5})
    for (const double y : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5})
      for (const double z : {-0.5, 0.0, 0.25, 0.5, 1.0, 1.5})
        CHECK(agree(closed.enclosure({x, y, z}, 0), enclosure(cube, {x, y, z}, 0)));
}

TEST("a mesh with a hole encloses nothing") {
  TriangleMesh mesh = ring(40, 24);
  mesh.triangles.erase(mesh.triangles.begin(), mesh.triangles.begin() + 400);
  const ClosedMesh closed = prepared(mesh);
  CHECK(!closed.enclosure({2, 0.1, 0}, 0));
  CHECK(!closed.enclosure({-2, 0.1, 0}, 0));
}

TEST("a seam that does not quite meet is as good as closed") {
  TriangleMesh mesh = ring(40, 24);
  for (std::size_t i = 0; i < 24; ++i) {  // the first ring of vertices once more, a little off
    mesh.vertices.push_back(mesh.vertices[i] + Vec3f{0, -1e-6F, 0});
    for (std::size_t t = 39 * 48; t < 40 * 48; ++t)
      for (std::uint32_t& corner : mesh.triangles[t])
        if (corner == i) corner = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  }
  check_everywhere(mesh, 0);
}

TEST("a point costs little more in a mesh of a hundred times as many triangles") {
  const double few = seconds_of_points(ring(40, 40)), many = seconds_of_points(ring(400, 400));
  CHECK(many < 12 * few);  // by all triangles, 100 times as much
}

TEST("a tree finds the boxes that touch another, and no others") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0, 10), size(0, 1);
  std::vector<Bounds> boxes;
  for (int i = 0; i < 300; ++i) {
    const Vec3d lo{place(random), place(random), i % 3 == 0 ? 5.0 : place(random)};
    boxes.push_back({lo, lo + Vec3d{size(random), size(random), size(random)}});
  }
  const BoxTree tree(boxes);
  for (const Bounds& box : boxes) {
    std::set<std::uint32_t> found, expected;
    tree.each_touching(box, [&](std::uint32_t i) { return found.insert(i).second; });
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
      if (touch(boxes[i], box)) expected.insert(i);
    CHECK(found == expected);
  }
  BoxTree(std::vector<Bounds>{}).each_touching(boxes[0], [](std::uint32_t) {
    return check::report(false, "", 0, "nothing"), true;
  });
}

TEST("each group is told which shape is its only instance") {
  const std::vector<ShapeDescription> shapes = {SphereDescription{}, InstanceDescription{2, {}},
                                                InstanceDescription{0, {}}, InstanceDescription{2, {}},
                                                InstanceDescription{2, {}}};
  const auto only = only_instances(shapes, 3);
  CHECK(only.size() == 3 && only[0] == 2U && !only[1] && !only[2]);
}

TEST("a description gives up the vertices of a mesh as they are taken, and their memory") {
  MeshDescription mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.later_vertices = {mesh.vertices};
  mesh.triangles = {{0, 1, 2}};
  const Normalization space = normalization_of(GroupDescription{{mesh}});
  CHECK(placed_mesh(0, mesh, space).vertices.size() == 3);
  CHECK(mesh.vertices.capacity() == 0 && mesh.later_vertices.capacity() == 0 && mesh.triangles.capacity() == 0);
}

int main() { return check::run(); }
