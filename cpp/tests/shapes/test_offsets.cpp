// Rays that leave a surface must not meet it again, and those that reach for a light must not meet the light: the error
// bounds of shapes/triangle_plane.h against Embree itself, over sizes, places and shapes of triangles. Where a bound is
// undone, the same test must see it.
#include <cmath>
#include <cstdio>
#include <random>

#include "equaltime/accel/accel.h"
#include "equaltime/scene/instance.h"
#include "equaltime/scene/surface.h"
#include "equaltime/shapes/interaction.h"
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
  OffsetPoint<float> anchor;
  Vec3f direction;
  bool above;
};

// A ray from a uniform point of the triangle, half of them within a thousandth of its plane.
Leaving leave(Random& random, const TriangleMesh& mesh, std::uint32_t k, float scale_of_offset) {
  const Triangle& t = mesh.triangles[k];
  const Vec3f &v0 = mesh.vertices[t[0]], &v1 = mesh.vertices[t[1]], &v2 = mesh.vertices[t[2]];
  const TrianglePlane<float> plane = triangle_plane(v0, v1, v2);
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

int self_hits(float scale_of_offset, int rays, Random& random) {
  const int triangles = 1000;
  TriangleMesh mesh = random_triangles(random, triangles);
  const TriangleMesh kept = mesh;
  std::vector<TriangleMesh> meshes;
  meshes.push_back(std::move(mesh));
  const Accel accel(Geometries{std::move(meshes)});
  int hits = 0;
  for (std::uint32_t k = 0; k < triangles; ++k)
    for (int i = 0; i < rays; ++i) {
      const Leaving ray = leave(random, kept, k, scale_of_offset);
      const auto hit = accel.closest(Ray{ray.anchor.moved(ray.above), ray.direction});
      hits += hit && hit->id.primitive == k;
    }
  return hits;
}

int self_hits(float scale_of_offset) {
  Random random;
  return self_hits(scale_of_offset, 1000, random);
}

TEST("a million rays leave random triangles without meeting them again (G1, G13)") { CHECK(self_hits(1) == 0); }

TEST("a ray leaves each of a million random triangles without meeting it again (G1)") {
  Random random;
  int hits = 0;
  for (int mesh = 0; mesh < 1000; ++mesh) hits += self_hits(1, 1, random);
  CHECK(hits == 0);
}

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
    const Accel accel(Geometries{std::move(meshes)});
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

/// A turn, unlike scales and a place: as an instance in normalised space, or far smaller.
InstanceGeometry random_instance(Random& random) {
  const Vec3d x = random.direction(), y = normalize(cross(x, random.direction())), z = cross(x, y);
  const double size = random.log_uniform(-5, 0);
  const auto scale = [&] { return size * random.log_uniform(-1.5, 0); };
  // Scaled along its own axes, then turned: rows and columns are both at odd angles.
  const Vec3d a = random.direction(), b = normalize(cross(a, random.direction())), c = cross(a, b);
  const double sx = scale(), sy = scale(), sz = scale() * (random.uniform(0, 1) < 0.3 ? -1 : 1);
  const auto column = [&](double ax, double bx, double cx) { return x * (sx * ax) + y * (sy * bx) + z * (sz * cx); };
  const Vec3f columns[4] = {Vec3f(column(a.x, b.x, c.x)), Vec3f(column(a.y, b.y, c.y)), Vec3f(column(a.z, b.z, c.z)),
                            Vec3f(random.direction() * random.log_uniform(-2, 3))};
  InstanceGeometry geometry{0, {}};
  for (std::size_t i = 0; i < 4; ++i) {
    geometry.to_world[3 * i] = columns[i].x;
    geometry.to_world[3 * i + 1] = columns[i].y;
    geometry.to_world[3 * i + 2] = columns[i].z;
  }
  return geometry;
}

int instanced_self_hits(double scale_of_offset) {
  Random random;
  int hits = 0;
  for (int i = 0; i < 500; ++i) {
    TriangleMesh mesh;
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(Vec3f(random.direction() * random.log_uniform(0, 3)));
    mesh.triangles = {{0, 1, 2}};
    const Vec3d v0(mesh.vertices[0]), e1 = Vec3d(mesh.vertices[1]) - v0, e2 = Vec3d(mesh.vertices[2]) - v0;
    const TrianglePlane<float> plane = triangle_plane(mesh.vertices[0], mesh.vertices[1], mesh.vertices[2]);
    const InstanceGeometry geometry = random_instance(random);
    const Instance instance(geometry);
    std::vector<Geometries> groups(1);
    groups[0].meshes.push_back(std::move(mesh));
    const Accel accel({}, Intersection::robust, std::move(groups), {geometry});
    for (int r = 0; r < 1000; ++r) {
      const double s = std::sqrt(random.uniform(0, 1)), u = 1 - s, v = s * random.uniform(0, 1);
      const ShapeHit<float> local{v0 + e1 * u + e2 * v, plane.n, plane.offset};
      const ShapeHit<float> met = instance.placed({local, {}, {}, 0, 0, false, false, {}}).hit;
      const Vec3f n(met.n);
      Vec3d d = random.direction();
      if (r % 2 == 0) d = d - met.n * (dot(met.n, d) * (1 - random.log_uniform(-5, -3)));
      const Vec3f direction(normalize(d));
      const OffsetPoint<float> anchor{Vec3f(met.p), n,
                                      static_cast<float>(static_cast<double>(met.offset) * scale_of_offset)};
      hits += accel.closest(Ray{anchor.moved(dot(direction, n) > 0), direction}).has_value();
    }
  }
  return hits;
}

TEST("half a million rays leave random instances without meeting them again") { CHECK(instanced_self_hits(1) == 0); }

TEST("with the offset undone, the same rays do meet them; how small it could be, for the record") {
  const int hits = instanced_self_hits(0);
  std::printf("  without offset: %d of half a million\n", hits);
  CHECK(hits > 1000);
  for (const double scale : {0.5, 0.25, 0.125, 0.0625})
    std::printf("  offset x %g: %d self-hits\n", scale, instanced_self_hits(scale));
}

}  // namespace

int main() { return check::run(); }
