// Rays that leave a surface must not meet it again, and those that reach for a light must not meet the light: the error
// bounds of scene/surface.h against Embree itself, over sizes, places and shapes of triangles. Where a bound is undone,
// the same test must see it.
#include <cmath>
#include <cstdio>
#include <random>

#include "accel/accel.h"
#include "scene/interaction.h"
#include "scene/surface.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

struct Random {
  std::mt19937_64 engine{7};
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double log_uniform(double a, double b) { return std::pow(10, uniform(a, b)); }
  Vec3d direction() {
    const double z = uniform(-1, 1), phi = uniform(0, 6.283185307179586), r = std::sqrt(1 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
};

// Triangles of sizes 1e-6 to 1e6 with aspects up to 1e3, at places up to 1e3 times their size from the origin.
TriangleMesh random_triangles(Random& random, int count) {
  TriangleMesh mesh;
  for (int i = 0; i < count; ++i) {
    const double size = random.log_uniform(-6, 6), aspect = random.log_uniform(-3, 0);
    const Vec3d place = random.direction() * (size * random.log_uniform(-3, 3));
    const Vec3d along = random.direction();
    const Vec3d across = normalize(cross(along, random.direction()));
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(Vec3f(place));
    mesh.vertices.push_back(Vec3f(place + along * size));
    mesh.vertices.push_back(Vec3f(place + along * (size * random.uniform(0, 1)) + across * (size * aspect)));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

struct Leaving {
  SurfaceAnchor anchor;
  Vec3f direction;
  bool above;
};

// A ray from a uniform point of the triangle, half of them within a thousandth of its plane.
Leaving leave(Random& random, const TriangleMesh& mesh, std::uint32_t k, float scale_of_offset) {
  const Triangle& t = mesh.triangles[k];
  const Vec3f &v0 = mesh.vertices[t[0]], &v1 = mesh.vertices[t[1]], &v2 = mesh.vertices[t[2]];
  const TrianglePlane plane = triangle_plane(v0, v1, v2);
  double u = random.uniform(0, 1), v = random.uniform(0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const Vec3d p = Vec3d(v0) + (Vec3d(v1) - Vec3d(v0)) * u + (Vec3d(v2) - Vec3d(v0)) * v;
  Vec3d d = random.direction();
  if (random.uniform(0, 1) < 0.5) {
    const Vec3d n(plane.n);
    d = d - n * (dot(n, d) * (1 - random.log_uniform(-7, -3)));
  }
  const Vec3f direction(normalize(d));
  return {{Vec3f(p), Vec3f(plane.n), plane.offset * scale_of_offset}, direction, dot(direction, Vec3f(plane.n)) > 0};
}

int self_hits(float scale_of_offset) {
  Random random;
  const int triangles = 1000, rays = 1000;
  TriangleMesh mesh = random_triangles(random, triangles);
  const TriangleMesh kept = mesh;
  std::vector<TriangleMesh> meshes;
  meshes.push_back(std::move(mesh));
  const Accel accel(Geometries{std::move(meshes), {}, {}, {}});
  int hits = 0;
  for (std::uint32_t k = 0; k < triangles; ++k)
    for (int i = 0; i < rays; ++i) {
      const Leaving ray = leave(random, kept, k, scale_of_offset);
      const auto hit = accel.intersect(Ray{ray.anchor.moved(ray.above), ray.direction});
      hits += hit && hit->primitive == k;
    }
  return hits;
}

TEST("a million rays leave random triangles without meeting them again (G1, G13)") { CHECK(self_hits(1) == 0); }

TEST("with the offset undone, the same rays do meet them") {
  const int hits = self_hits(0);
  std::printf("  without offset: %d of a million\n", hits);
  CHECK(hits > 1000);
}

TEST("how small the offset could be, for the record") {
  for (const float scale : {0.5F, 0.25F, 0.125F, 0.0625F})
    std::printf("  offset x %g: %d self-hits of a million\n", static_cast<double>(scale), self_hits(scale));
}

// Shadow rays between two triangles: neither end may be met.
int met_ends(float scale_of_offset) {
  Random random;
  int met = 0;
  for (int i = 0; i < 300; ++i) {
    const double size = random.log_uniform(-4, 4);
    TriangleMesh mesh;
    for (int k = 0; k < 2; ++k) {
      const Vec3d place = random.direction() * (size * random.log_uniform(-1, 2));
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int v = 0; v < 3; ++v) mesh.vertices.push_back(Vec3f(place + random.direction() * size));
      mesh.triangles.push_back({first, first + 1, first + 2});
    }
    const TriangleMesh kept = mesh;
    std::vector<TriangleMesh> meshes;
    meshes.push_back(std::move(mesh));
    const Accel accel(Geometries{std::move(meshes), {}, {}, {}});
    for (int r = 0; r < 1000; ++r) {
      const Leaving a = leave(random, kept, 0, scale_of_offset);
      Leaving b = leave(random, kept, 1, scale_of_offset);
      const Vec3f d = b.anchor.p - a.anchor.p;
      if (dot(b.anchor.n, d) > 0) b.anchor.n = -b.anchor.n;
      Interaction it{};
      it.anchor = a.anchor;
      Ray ray = it.spawn_to(b.anchor, length(d) * scale_of_offset, dot(a.anchor.n, d) > 0);
      // Two triangles may cut each other: only what is met at an end counts, and there nothing else stands.
      const Vec3f third = ray.direction * (1.0F / 3);
      const bool crossing = accel.occluded(Ray{ray.origin + third, third, 1.0F});
      met += !crossing && accel.occluded(ray);
    }
  }
  return met;
}

TEST("shadow rays between random triangles meet neither end (G17)") { CHECK(met_ends(1) == 0); }

TEST("with the offsets undone, the same shadow rays meet their ends") { CHECK(met_ends(0) > 1000); }

}  // namespace

int main() { return check::run(); }
