// Warps at the ends of the unit interval and next to them: what comes out is finite and where it must be, and no
// floating-point fault is raised on the way.
#include <cmath>
#include <random>

#include "equaltime/base/floating_point.h"
#include "equaltime/sampling/spherical_rectangle.h"
#include "equaltime/sampling/spherical_triangle.h"
#include "equaltime/sampling/warps.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

/// What samplers give at most is 1 - 2^-24.
constexpr float kEnds[] = {0.0F, 0x1p-32F,        0x1.000002p-32F, 0x1p-24F,       0x1p-23F, 0.5F - 0x1p-25F,
                           0.5F, 0.5F + 0x1p-24F, 1.0F - 0x1p-23F, 1.0F - 0x1p-24F};

template <class Each>
void at_all_ends(Each&& each) {
  for (const float x : kEnds)
    for (const float y : kEnds) {
      (void)take_faults();
      each(Point2f{x, y});
      CHECK(take_faults() == 0);
    }
}

bool is_unit(const Vec3d& v) { return std::abs(length(v) - 1) < 1e-6; }

struct Random {
  std::mt19937_64 engine{1};
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double log_uniform(double a, double b) { return std::pow(10, uniform(a, b)); }
  Vec3d vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
};

TEST("warps of the square end on their disk, polygon, sphere and hemisphere") {
  at_all_ends([](Point2f u) {
    const Point2f disk = square_to_disk(u), polygon = square_to_polygon(u, 5, 0.3F);
    CHECK(disk.x * disk.x + disk.y * disk.y <= 1.00001F);
    CHECK(polygon.x * polygon.x + polygon.y * polygon.y <= 1.00001F);
    for (const Vec3f& v :
         {square_to_cosine_hemisphere(u), square_to_uniform_sphere(u), square_to_uniform_hemisphere(u)})
      CHECK(is_unit(Vec3d(v)));
  });
}

TEST("directions to triangles of any size end within them") {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const double size = random.log_uniform(-6, 3);
    const Vec3d v0 = random.vector() + Vec3d{0, 0, 2}, e1 = random.vector() * size, e2 = random.vector() * size;
    const SphericalTriangle triangle(v0, e1, e2);
    const Vec3d inside = normalize(v0 + (e1 + e2) / 3.0);
    const Vec3d corners[] = {normalize(v0), normalize(v0 + e1), normalize(v0 + e2)};
    double reach = 0;
    for (const Vec3d& c : corners) reach = std::max(reach, length(c - inside));
    at_all_ends([&](Point2f u) {
      const Vec3d w = triangle.sample(u);
      CHECK(is_unit(w));
      if (reach < 0.5) CHECK(length(w - inside) <= 1.2 * reach + 1e-7);
    });
  }
}

TEST("points of rectangles of any size are on them, also for receivers in their plane, above a corner or an edge") {
  Random random;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d x = normalize(random.vector()), y = normalize(cross(x, random.vector())), z = cross(x, y);
    const double width = random.log_uniform(-6, 3), height = random.log_uniform(-6, 3);
    const double sideways = i % 3 == 0 ? 0.0 : random.uniform(-2, 2), across = i % 5 == 0 ? 0.0 : random.uniform(-2, 2);
    const Vec3d corner = x * sideways + y * across + z * random.log_uniform(-3, 1);
    const SphericalRectangle rectangle(corner, x, y, width, height);
    at_all_ends([&](Point2f u) {
      const Vec3d p = rectangle.sample(u) - corner;
      CHECK(dot(p, x) >= -1e-9 * width - 1e-12 && dot(p, x) <= width * (1 + 1e-9) + 1e-12);
      CHECK(dot(p, y) >= -1e-9 * height - 1e-12 && dot(p, y) <= height * (1 + 1e-9) + 1e-12);
    });
  }
}

TEST("a fault is seen where there is one") {
  volatile float zero = 0;
  (void)take_faults();
  const volatile float quotient = 1 / zero;
  CHECK(quotient > 0 && take_faults() == FE_DIVBYZERO);
  CHECK(take_faults() == 0);
}

}  // namespace

int main() { return check::run(); }
