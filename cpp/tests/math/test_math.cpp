// Frames, series, exact products and bit tricks against the same in more digits.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "equaltime/base/bits.h"
#include "equaltime/math/elementary.h"
#include "equaltime/math/frame.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/transform.h"
#include "equaltime/sampling/sobol.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

constexpr double kUlp = 2 * static_cast<double>(kUnitRoundoff);

std::vector<Vec3f> unit_normals(int each = 200) {
  std::vector<Vec3f> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {1, 0, -0.0F}};
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  // From even over the sphere to ever closer to the poles, where other constructions lose their digits.
  for (double narrow = 1; narrow > 1e-40; narrow *= 0.1)
    for (int i = 0; i < each; ++i) {
      const Vec3d v{gauss(random) * narrow, gauss(random) * narrow, gauss(random)};
      normals.emplace_back(normalize(v));
    }
  return normals;
}

// The largest departure of a frame from three orthogonal unit vectors, right-handed, the last of them n.
template <class F>
double departure(const F& frame, const Vec3f& n) {
  const Vec3d s(frame.s), t(frame.t), z(n);
  const Vec3d handed = cross(s, t) - z;
  double most = max_component(abs(handed));
  for (const double error : {dot(s, t), dot(s, z), dot(t, z), length(s) - 1, length(t) - 1})
    most = std::max(most, std::abs(error));
  return most;
}

TEST("a frame is orthonormal and right-handed for every normal, the poles included") {
  double most = 0;
  for (const Vec3f& n : unit_normals(250'000)) most = std::max(most, departure(Frame::from_normal(n), n));
  CHECK(most < 4 * kUlp);  // of ten million
}

TEST("the frame test rejects a frame that is a little askew") {
  const Vec3f n{0, 0, -1};
  Frame askew = Frame::from_normal(n);
  askew.s.z += 1e-6F;
  CHECK(departure(askew, n) > 4 * kUlp);
}

TEST("a direction comes back from local coordinates, and its cosine is z") {
  std::mt19937 random(2);
  std::normal_distribution<double> gauss;
  for (const Vec3f& n : unit_normals()) {
    const Vec3f v(normalize(Vec3d{gauss(random), gauss(random), gauss(random)}));
    const Frame frame = Frame::from_normal(n);
    const Vec3f local = frame.to_local(v);
    CHECK(max_component(abs(Vec3d(frame.to_world(local)) - Vec3d(v))) < 8 * kUlp);
    CHECK(std::abs(static_cast<double>(local.z) - dot(Vec3d(v), Vec3d(n))) < 2 * kUlp);
  }
}

TEST("the octant's sine is right to half a unit in the last place of 1, its cosine to one") {
  double sine = 0, cosine = 0;
  const auto compare = [&](float x) {
    const SinCos value = sin_cos_octant(x);
    const auto exact = static_cast<double>(x);
    sine = std::max(sine, std::abs(static_cast<double>(value.sin) - std::sin(exact)));
    cosine = std::max(cosine, std::abs(static_cast<double>(value.cos) - std::cos(exact)));
  };
  const float end = kPi / 4;
  for (int i = -200000; i <= 200000; ++i) compare(end * (static_cast<float>(i) / 200000));
  for (float x = end; x > 1e-30F; x *= 0.9F) compare(x);
  CHECK(sine < 0.5 * kUlp && cosine < kUlp);
}

TEST("sine and cosine of a part of a turn are right to two units in the last place of 1") {
  double worst = 0, rounded_angle = 0;  // the twin: rounds the angle before it is reduced
  const auto error = [](const SinCos<float>& value, double angle) {
    return std::max(std::abs(static_cast<double>(value.sin) - std::sin(angle)),
                    std::abs(static_cast<double>(value.cos) - std::cos(angle)));
  };
  const auto compare = [&](float u) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(u);
    worst = std::max(worst, error(sin_cos_turn(u), angle));
    rounded_angle = std::max(rounded_angle, error(sin_cos(kTwoPi * u), angle));
  };
  for (int i = 0; i <= 800000; ++i) compare(static_cast<float>(i) / 800000);
  for (const float edge : {0.125F, 0.25F, 0.375F, 0.5F, 0.625F, 0.75F, 0.875F})
    for (const float u : {std::nextafter(edge, 0.0F), edge, std::nextafter(edge, 1.0F)}) compare(u);
  for (const float u : {0x1p-32F, 0x1p-24F, kOneMinusEpsilon, 1.0F}) compare(u);
  CHECK(worst < 2 * kUlp);
  CHECK(rounded_angle > 2 * kUlp);
}

TEST("bits are reversed") {
  std::mt19937 random(4);
  CHECK(reverse_bits(1U) == 0x80000000U);
  CHECK(reverse_bits(0x0000ffffU) == 0xffff0000U);
  for (int i = 0; i < 10000; ++i) {
    const auto x = static_cast<std::uint32_t>(random());
    CHECK(reverse_bits(reverse_bits(x)) == x);
  }
}

TEST("a number of the unit interval never reaches 1") {
  CHECK(unit_float(0) == 0);
  CHECK(unit_float(~0U) == kOneMinusEpsilon);
  CHECK(unit_float(~0U) < 1);
  bool all = true;
  for (std::uint32_t top = 0; top < 1U << 24; ++top)  // whatever follows, it is these bits that are kept
    for (const std::uint32_t below : {0U, 0xffU})
      all = all && unit_float(top << 8 | below) == static_cast<float>(top) * 0x1p-24F;
  CHECK(all);
}

TEST("a transform moves points and turns vectors") {
  const Transform t{{{{0, -2, 0, 10}, {2, 0, 0, 20}, {0, 0, 2, 30}, {0, 0, 0, 1}}}};
  CHECK((t.point({1, 2, 3}) == Vec3d{6, 22, 36}));
  CHECK((t.vector({1, 2, 3}) == Vec3d{-4, 2, 6}));
  CHECK((t.column(3) == Vec3d{10, 20, 30}));
}

}  // namespace

int main() { return check::run(); }
