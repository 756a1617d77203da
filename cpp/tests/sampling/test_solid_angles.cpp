// Solid angles of triangles and rectangles against long double, and samples against the shape that they must lie on.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "equaltime/sampling/spherical_rectangle.h"
#include "equaltime/sampling/spherical_triangle.h"
#include "tests/check.h"
#include "tests/statistics.h"

namespace {

using namespace equaltime;
using Real = long double;
using Vec = Vec3<Real>;

// L'Huilier's theorem, from the sides as half-chord angles: another formula than the subject's, in more digits.
Real triangle_solid_angle(const Vec& v0, const Vec& e1, const Vec& e2) {
  const Vec a = normalize(v0), b = normalize(v0 + e1), c = normalize(v0 + e2);
  const auto side = [](const Vec& p, const Vec& q) { return 2 * std::atan2(length(p - q), length(p + q)); };
  const Real x = side(b, c), y = side(c, a), z = side(a, b), s = (x + y + z) / 2;
  const Real product = std::tan(s / 2) * std::tan((s - x) / 2) * std::tan((s - y) / 2) * std::tan((s - z) / 2);
  return 4 * std::atan(std::sqrt(std::max(product, Real{0})));
}

// The sum of four signed corner angles.
Real rectangle_solid_angle(Real x0, Real y0, Real x1, Real y1, Real z) {
  const auto corner = [z](Real x, Real y) { return std::atan2(x * y, z * std::sqrt(x * x + y * y + z * z)); };
  return corner(x1, y1) - corner(x0, y1) + corner(x0, y0) - corner(x1, y0);
}

struct Random {
  std::mt19937_64 engine{1};
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double log_uniform(double a, double b) { return std::pow(10, uniform(a, b)); }
  Vec3d vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  Point2f unit() { return {static_cast<float>(uniform(0, 1)), static_cast<float>(uniform(0, 1))}; }
};

TEST("the solid angle of a triangle is right over sizes from a millionth to a thousand of its distance") {
  Random random;
  for (int i = 0; i < 100000; ++i) {
    const double size = random.log_uniform(-6, 3);
    const Vec3d v0 = normalize(random.vector()), e1 = random.vector() * size, e2 = random.vector() * size;
    const Real exact = triangle_solid_angle(Vec(v0), Vec(e1), Vec(e2));
    // Both formulas lose digits when the receiver is in the plane of the triangle, or in line with an edge.
    const Vec3d n = normalize(cross(e1, e2));
    if (std::abs(dot(n, v0)) < 0.01) continue;
    const double error = std::abs(static_cast<double>((SphericalTriangle(v0, e1, e2).solid_angle() - exact) / exact));
    CHECK(error < 1e-8);
  }
}

TEST("triangles around the receiver fill the sphere") {
  const Vec3d v[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3d &a = v[i], &b = v[(i + 1) % 4], &c = v[(i + 2) % 4];
    sum += SphericalTriangle(a, b - a, c - a).solid_angle();
  }
  CHECK(std::abs(sum - 4 * std::numbers::pi) < 1e-13);
}

TEST("the solid angle of a rectangle is right over sizes, distances and oblique views") {
  Random random;
  for (int i = 0; i < 100000; ++i) {
    const double width = random.log_uniform(-4, 3), height = random.log_uniform(-4, 3);
    const double x0 = random.uniform(-2, 1) * width, y0 = random.uniform(-2, 1) * height;
    const double z = random.log_uniform(-4, 1);
    const Real exact = rectangle_solid_angle(x0, y0, Real{x0} + width, Real{y0} + height, z);
    const double value = SphericalRectangle({x0, y0, z}, {1, 0, 0}, {0, 1, 0}, width, height).solid_angle();
    // Corner angles up to π cancel: an absolute bound of a few float64 ulp of 2π, and a relative one for large views.
    CHECK(std::abs(static_cast<double>(static_cast<Real>(value) - exact)) < 4e-15 + 1e-13 * static_cast<double>(exact));
  }
}

TEST("a receiver close to a rectangle sees half the sphere, and one in its plane outside it sees nothing") {
  CHECK(std::abs(SphericalRectangle({-1, -1, -1e-9}, {1, 0, 0}, {0, 1, 0}, 2, 2).solid_angle() - 2 * std::numbers::pi) <
        1e-8);
  CHECK(SphericalRectangle({1, 1, -1e-12}, {1, 0, 0}, {0, 1, 0}, 2, 2).solid_angle() < 1e-11);
}

TEST("samples of a rectangle are points of it") {
  Random random;
  for (int i = 0; i < 100000; ++i) {
    const double width = random.log_uniform(-3, 2), height = random.log_uniform(-3, 2);
    const Vec3d corner{random.uniform(-2, 1) * width, random.uniform(-2, 1) * height, -random.log_uniform(-3, 1)};
    const SphericalRectangle rectangle(corner, {1, 0, 0}, {0, 1, 0}, width, height);
    const Vec3d p = rectangle.sample(random.unit());
    CHECK(p.x >= corner.x && p.x <= corner.x + width && p.y >= corner.y && p.y <= corner.y + height);
    CHECK(p.z == corner.z);
  }
}

// By how much, as an angle, a direction is outside the triangle's three planes through the receiver.
double outside(const Vec3d& v0, const Vec3d& e1, const Vec3d& e2, const Vec3d& direction) {
  const Vec3d v[3] = {normalize(v0), normalize(v0 + e1), normalize(v0 + e2)};
  const double side = dot(cross(v[0], v[1]), v[2]) < 0 ? -1 : 1;
  double most = 0;
  for (int i = 0; i < 3; ++i) most = std::max(most, -side * dot(normalize(cross(v[i], v[(i + 1) % 3])), direction));
  return most;
}

TEST("samples of a triangle are unit directions towards it") {
  Random random;
  for (int i = 0; i < 100000; ++i) {
    const double size = random.log_uniform(-2, 1);
    const Vec3d v0 = normalize(random.vector()), e1 = random.vector() * size, e2 = random.vector() * size;
    const SphericalTriangle triangle(v0, e1, e2);
    if (triangle.solid_angle() < 1e-8) continue;
    const Vec3d w = triangle.sample(random.unit());
    CHECK(std::abs(length(w) - 1) < 1e-9);
    CHECK(outside(v0, e1, e2, w) < 1e-7);
  }
}

// How samples of a triangle fall into its 64 parts, of which each edge has eight: χ² against the parts' solid angles,
// as a deviate. With a tilt, parts on one side are said to be so much larger.
double deviate_over_parts(const Vec3d& v0, const Vec3d& e1, const Vec3d& e2, double tilt) {
  constexpr int kSide = 8, kDraws = 200000;
  const SphericalTriangle triangle(v0, e1, e2);
  const Real whole = triangle_solid_angle(Vec(v0), Vec(e1), Vec(e2));
  std::vector<double> counts(2 * kSide * kSide, 0), expected(counts.size(), 0);
  const auto part = [](int i, int j, int upper) { return static_cast<std::size_t>(2 * (kSide * i + j) + upper); };
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; i + j < kSide; ++j)
      for (int upper = 0; i + j + upper < kSide; ++upper) {
        const Vec3d corner = v0 + e1 * ((i + upper) / double{kSide}) + e2 * ((j + upper) / double{kSide});
        const Vec3d a = e1 * ((upper ? -1.0 : 1.0) / kSide), b = e2 * ((upper ? -1.0 : 1.0) / kSide);
        const Real share = triangle_solid_angle(Vec(corner), Vec(a), Vec(b)) / whole;
        expected[part(i, j, upper)] = kDraws * (1 + tilt * (i - 2)) * static_cast<double>(share);
      }
  const Vec3d n = cross(e1, e2);
  Random random;
  for (int k = 0; k < kDraws; ++k) {
    const Vec3d w = triangle.sample(random.unit());
    const Vec3d p = w * (dot(n, v0) / dot(n, w)) - v0;
    const auto place = [&](const Vec3d& v) {
      return std::clamp(kSide * dot(v, n) / length_squared(n), 0.0, kSide - 1e-9);
    };
    const double x = place(cross(p, e2)), y = place(cross(e1, p));
    const int i = static_cast<int>(x), j = std::min(static_cast<int>(y), kSide - 1 - i);
    ++counts[part(i, j, i + j + 1 < kSide && x - i + y - j > 1 ? 1 : 0)];
  }
  std::vector<double> seen, meant;
  for (std::size_t k = 0; k < counts.size(); ++k)
    if (expected[k] > 0) seen.push_back(counts[k]), meant.push_back(expected[k]);
  return statistics::chi_squared_deviate(seen, meant);
}

TEST("samples of a triangle are spread by solid angle, from a tenth of one down to a billionth (S9)") {
  const Vec3d v0 = normalize(Vec3d{0.3, -0.2, 1}), e1{1, 0.2, 0.1}, e2{0.1, 0.9, -0.3};
  for (const double solid_angle : {1e-1, 1e-3, 1e-5, 1e-7, 1e-9}) {
    const double size = std::sqrt(2 * solid_angle);
    CHECK(std::abs(deviate_over_parts(v0, e1 * size, e2 * size, 0)) < statistics::kReject);
    CHECK(deviate_over_parts(v0, e1 * size, e2 * size, 0.02) > statistics::kReject);  // the twin
  }
}

// How directions fall into 64 parts of the half world above, of equal solid angle; the upper half of them may be said
// to be so much larger.
double deviate_over_sky(const SphericalTriangle& triangle, double tilt) {
  constexpr int kSide = 8, kDraws = 200000;
  std::vector<double> counts(kSide * kSide, 0), expected;
  Random random;
  for (int k = 0; k < kDraws; ++k) {
    const Vec3d w = triangle.sample(random.unit());
    const auto cell = [](double x) { return std::clamp(static_cast<int>(kSide * x), 0, kSide - 1); };
    ++counts[static_cast<std::size_t>(kSide * cell(w.z) + cell(0.5 + std::atan2(w.y, w.x) / (2 * std::numbers::pi)))];
  }
  for (int k = 0; k < kSide * kSide; ++k)
    expected.push_back(kDraws * (1 + (2 * k < kSide * kSide ? -tilt : tilt)) / (kSide * kSide));
  return statistics::chi_squared_deviate(counts, expected);
}

TEST("samples of a triangle that covers half the world are spread by solid angle (S10)") {
  const Vec3d e1{1000, 0, 0}, e2{1000, 1000, 0};
  for (const Vec3d corner : {Vec3d{-800, -400, 0}, Vec3d{-600, -200, 0}, Vec3d{-503, -500, 0}, Vec3d{-999, -3, 0}})
    for (const double height : {1e-4, 1e-6, 1e-7}) {
      const SphericalTriangle triangle(corner + Vec3d{0, 0, height}, e1, e2);
      CHECK(std::abs(triangle.solid_angle() - 2 * std::numbers::pi) < 1e-3);
      CHECK(std::abs(deviate_over_sky(triangle, 0)) < statistics::kReject);
      CHECK(deviate_over_sky(triangle, 0.04) > statistics::kReject);  // the twin
    }
}

TEST("halves of a triangle's samples fall into its halves of equal solid angle") {
  // The first number is the share of the solid angle: u.x < 1/2 are the samples of a part of half the solid angle.
  const Vec3d v0{0, 0, 1}, e1{1.5, 0, 0}, e2{0, 1.5, 0};
  const SphericalTriangle whole(v0, e1, e2);
  for (const double share : {0.1, 0.5, 0.9}) {
    const Vec3d w =
        whole.sample({static_cast<float>(share), 1.0F - 0x1p-24F});  // on the side opposite to the second vertex
    const Vec3d on_edge = w * (1 / w.z) - v0;
    CHECK(std::abs(SphericalTriangle(v0, e1, on_edge).solid_angle() / whole.solid_angle() - share) < 1e-5);
  }
}

}  // namespace

int main() { return check::run(); }
