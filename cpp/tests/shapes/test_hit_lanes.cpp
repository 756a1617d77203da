// Hits over lanes: each lane has the bits that one path has.
#include "equaltime/shapes/exact_hit.h"

#include <array>
#include <vector>

#include "tests/check.h"
#include "tests/lanes.h"
#include "tests/random_lights.h"

namespace {

using namespace random_scene;

/// The numbers that a shape is made of, and the ray that it is asked with.
template <class Real>
struct Case {
  std::array<Vec3<Real>, 3> corners, normals;
  Vec3<Double<Real>> at, x, y, axis;
  Double<Real> radius, length;
  BasicRay<Real> ray;
};

/// Rays start within shapes and beyond them, and meet and miss them. Some run along an axis of shapes or in a plane of
/// theirs, and some normals cancel.
Case<float> random_case(Random& random) {
  Case<float> c{};
  const bool aligned = random.engine() % 4 == 0, cancelled = random.engine() % 8 == 0;
  c.axis = aligned ? Vec3d{0, 0, 1} : random.direction();
  c.x = normalize(cross(c.axis, Vec3d{1, 0.5, 0.25})) * random.in(0.5, 2), c.y = cross(c.axis, c.x);
  c.at = random.point(0.5);
  c.radius = random.in(0.1, 1.5), c.length = random.in(0.1, 2);
  c.corners = {Vec3f(c.at), Vec3f(c.at + c.x), Vec3f(c.at + c.y)};
  for (Vec3f& normal : c.normals) normal = cancelled ? Vec3f{} : Vec3f(c.axis + random.point(1));
  const Vec3d origin = random.point(2), along[2] = {{0, 0, 1}, {0.6, 0.8, 0}};
  const Vec3d target = c.at + c.x * random.in(-1, 1) + c.y * random.in(-1, 1);
  const Vec3d direction = aligned ? along[random.engine() % 2] : normalize(target - origin);
  c.ray = {Vec3f(origin), Vec3f(direction), random.engine() % 2 == 0 ? kInfinity : 2.0F};
  return c;
}

void set_lane(Case<Floats>& wide, std::size_t i, const Case<float>& one) {
  for (std::size_t k = 0; k < 3; ++k)
    set_lane(wide.corners[k], i, one.corners[k]), set_lane(wide.normals[k], i, one.normals[k]);
  set_lane(wide.at, i, one.at), set_lane(wide.x, i, one.x), set_lane(wide.y, i, one.y);
  set_lane(wide.axis, i, one.axis);
  wide.radius[i] = one.radius, wide.length[i] = one.length;
  set_lane(wide.ray.origin, i, one.ray.origin), set_lane(wide.ray.direction, i, one.ray.direction);
  wide.ray.t_max[i] = one.ray.t_max;
}

/// Whether the ray meets the shape, and all numbers of the hit.
template <class Real>
struct Found {
  Mask<Real> has_value;
  std::vector<Double<Real>> numbers = {};

  template <class T>
  void add(const Vec3<T>& v) {
    for (const T& number : {v.x, v.y, v.z}) numbers.push_back(Double<Real>(number));
  }
  void add(const ShapeHit<Real>& hit) { add(hit.p), add(hit.n), numbers.push_back(Double<Real>(hit.offset)); }
};

template <class Real>
Found<Real> found(const Optional<Double<Real>>& t, const ShapeHit<Real>& hit) {
  Found<Real> found{t.has_value(), {where(t.has_value(), [&] { return *t; })}};
  found.add(hit);
  return found;
}

bool agrees(const Found<Floats>& wide, std::size_t i, const Found<float>& one) {
  bool agrees = wide.has_value[i] == one.has_value;
  for (std::size_t k = 0; k < one.numbers.size(); ++k) agrees = agrees && same(wide.numbers[k][i], one.numbers[k]);
  return agrees;
}

/// `find` finds the hit of a case, of lanes or of one path.
template <class Find>
void check_hits(Find&& find) {
  Random random(1);
  const NextLane next = check_lanes<Case>(
      1000, [&] { return random_case(random); }, find);
  CHECK(next.differs == 4000);
  CHECK(next.parts > 500);
}

TEST("lanes of a triangle have the bits of one path") {
  check_hits([]<class Real>(const Case<Real>& c) {
    const auto& [v0, v1, v2] = c.corners;
    const auto& [n0, n1, n2] = c.normals;
    const TrianglePlane<Real> plane = triangle_plane(v0, v1, v2);
    const ShapeHit<Real> hit{plane.meet(BasicRayD<Real>(c.ray)), plane.n, plane.offset};
    const Barycentric<Real> at = barycentric(v0, v1, v2, hit.p);
    Found<Real> found{at.u > 0 && at.v > 0 && at.u + at.v < 1};
    found.add(hit);
    found.add(Vec3<Real>(at.u, at.v, 0));
    found.add(interpolated_normal(n0, n1, n2, at, Vec3<Real>(plane.n)));
    return found;
  });
}

TEST("lanes of a sphere have the bits of one path") {
  check_hits([]<class Real>(const Case<Real>& c) {
    const Sphere<Real> sphere{c.at, c.radius};
    const BasicRayD<Real> ray(c.ray);
    return found(intersect(sphere, ray), exact_hit(sphere, ray));
  });
}

TEST("lanes of a disk have the bits of one path") {
  check_hits([]<class Real>(const Case<Real>& c) {
    const Disk<Real> disk{c.at, c.axis, c.x / length_squared(c.x), c.y / length_squared(c.y)};
    const BasicRayD<Real> ray(c.ray);
    return found(intersect(disk, ray), exact_hit(disk, ray));
  });
}

TEST("lanes of a cylinder have the bits of one path") {
  check_hits([]<class Real>(const Case<Real>& c) {
    const Cylinder<Real> tube{c.at, c.axis, c.length, c.radius};
    const BasicRayD<Real> ray(c.ray);
    const auto [hit, height] = exact_hit(tube, ray);
    auto with_height = found(intersect(tube, ray), hit);
    with_height.numbers.push_back(height);
    return with_height;
  });
}

}  // namespace

int main() { return check::run(); }
