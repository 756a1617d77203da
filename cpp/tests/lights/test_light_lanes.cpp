// Lights over lanes: each lane has the bits that one path has.
#include <cstdint>

#include "tests/check.h"
#include "tests/lanes.h"
#include "tests/random_lights.h"

namespace {

using namespace random_scene;

/// The numbers that a light is made of, and those that it is asked with.
template <class Real>
struct Case {
  Vec3<Double<Real>> at, x, y;
  Double<Real> radius;
  Mask<Real> turned;
  Rgb<Real> radiance;
  Vec3<Real> receiver, wi, point;
  Point2<Real> u;
  Real pmf;
};

/// Sizes and distances are such that lights are near and far, that receivers stand before and behind them, and that
/// directions meet and miss them.
Case<float> random_case(Random& random) {
  const auto number = [&](double lo, double hi) { return static_cast<float>(random.in(lo, hi)); };
  const double size = random.in(0.1, 2);
  const Vec3d x = random.direction() * size, y = normalize(cross(x, random.direction())) * (size * random.in(0.1, 1));
  const Vec3d at = random.point(0.5);
  const Vec3f receiver(random.point(1)), point(at + x * random.in(-0.2, 1) + y * random.in(-0.2, 1));
  return {at,
          x,
          y,
          random.in(0.1, 2),
          random.engine() % 2 == 0,
          {number(0, 1), number(0, 1), number(0, 1)},
          receiver,
          normalize(point - receiver),
          point,
          {number(0, 1), number(0, 1)},
          number(0.1, 1)};
}

void set_lane(Case<Floats>& wide, std::size_t i, const Case<float>& one) {
  set_lane(wide.at, i, one.at), set_lane(wide.x, i, one.x), set_lane(wide.y, i, one.y);
  wide.radius[i] = one.radius, wide.turned[i] = one.turned;
  set_lane(wide.radiance, i, one.radiance);
  set_lane(wide.receiver, i, one.receiver), set_lane(wide.wi, i, one.wi), set_lane(wide.point, i, one.point);
  wide.u.x[i] = one.u.x, wide.u.y[i] = one.u.y, wide.pmf[i] = one.pmf;
}

bool same_sample(const LightSample<Floats>& samples, std::size_t i, const LightSample<float>& sample) {
  return same(lane(samples.wi, i), sample.wi) && same(lane(samples.radiance, i), sample.radiance) &&
         same(samples.pdf[i], sample.pdf) && same(samples.distance[i], sample.distance) &&
         same(lane(samples.target.p, i), sample.target.p) && same(lane(samples.target.n, i), sample.target.n) &&
         same(samples.target.offset[i], sample.target.offset) && samples.infinite[i] == sample.infinite &&
         samples.delta[i] == sample.delta && samples.light[i] == sample.light;
}

template <class Light, class Real>
Optional<LightSample<Real>> sampled(const Light& light, const Case<Real>& c) {
  if constexpr (requires { light.sample(c.receiver, c.u, c.pmf); })
    return light.sample(c.receiver, c.u, c.pmf);
  else if constexpr (requires { light.sample(c.receiver, c.pmf); })
    return {light.sample(c.receiver, c.pmf), true};
  else
    return {light.sample(c.pmf), true};
}

/// Whether lane i of a light of lanes has the same bits as the light of one path.
template <class Wide, class One>
bool agrees(const Wide& wide, const Case<Floats>& asked, std::size_t i, const One& one, const Case<float>& c) {
  const auto samples = sampled(wide, asked);
  const auto sample = sampled(one, c);
  if (samples.has_value()[i] != sample.has_value()) return false;
  if (sample && !same_sample(*samples, i, *sample)) return false;
  if constexpr (requires { one.faces(c.receiver); })
    return wide.faces(asked.receiver)[i] == one.faces(c.receiver) &&
           same(wide.pdf(asked.receiver, asked.wi, asked.point)[i], one.pdf(c.receiver, c.wi, c.point)) &&
           same(wide.pdf_direction(asked.receiver, asked.wi)[i], one.pdf_direction(c.receiver, c.wi));
  return true;
}

/// `make` makes a light of a case, of lanes or of one path.
template <class Make>
void check_lanes(Make&& make) {
  Random random(1);
  int mixed_up = 0, parted = 0;  // the twin: numbers of the next lane do not give the same
  for (int k = 0; k < 500; ++k) {
    std::array<Case<float>, kLanes> cases;
    Case<Floats> all{};
    for (std::size_t i = 0; i < kLanes; ++i) set_lane(all, i, cases[i] = random_case(random));
    const auto wide = make(all);
    static_assert(kHasLanes<decltype(make(cases[0]))>);
    for (std::size_t i = 0; i < kLanes; ++i) {
      const Case<float>&one = cases[i], &next = cases[(i + 1) % kLanes];
      CHECK(agrees(wide, all, i, make(one), one));
      mixed_up += !agrees(wide, all, i, make(next), next);
      parted += sampled(make(one), one).has_value() != sampled(make(next), next).has_value();
    }
  }
  CHECK(mixed_up > 500);
  CHECK(parted > 100 || !requires(decltype(make(Case<float>{})) light, Vec3f p) { light.faces(p); });
}

TEST("lanes of a triangle have the bits of one path") {
  check_lanes([]<class Real>(const Case<Real>& c) {
    return TriangleLight<Real>(Vec3<Real>(c.at), Vec3<Real>(c.at + c.x), Vec3<Real>(c.at + c.y), c.radiance);
  });
}

TEST("lanes of a rectangle have the bits of one path") {
  check_lanes([]<class Real>(const Case<Real>& c) {
    return RectangleLight<Real>(Vec3<Real>(c.at), c.x, c.y, c.turned, c.radiance);
  });
}

TEST("lanes of a sphere have the bits of one path") {
  check_lanes([]<class Real>(const Case<Real>& c) { return SphereLight<Real>(c.at, c.radius, c.turned, c.radiance); });
}

TEST("lanes of a disk have the bits of one path") {
  check_lanes([]<class Real>(const Case<Real>& c) { return DiskLight<Real>(c.at, c.x, c.y, c.turned, c.radiance); });
}

TEST("lanes of a point and of a direction have the bits of one path") {
  check_lanes([]<class Real>(const Case<Real>& c) { return PointLight<Real>{Vec3<Real>(c.at), c.radiance}; });
  check_lanes([]<class Real>(const Case<Real>& c) { return DirectionalLight<Real>{c.wi, c.radiance}; });
}

TEST("lanes of a point off a surface have the bits of one path") {
  Random random(2);
  for (int k = 0; k < 500; ++k) {
    std::array<Case<float>, kLanes> cases;
    Case<Floats> all{};
    for (std::size_t i = 0; i < kLanes; ++i) set_lane(all, i, cases[i] = random_case(random));
    const auto moved = []<class Real>(const Case<Real>& c) {
      return OffsetPoint<Real>{c.point, c.wi, point_offset(c.point, c.wi)}.moved(c.turned);
    };
    for (std::size_t i = 0; i < kLanes; ++i) CHECK(same(lane(moved(all), i), moved(cases[i])));
  }
}

}  // namespace

int main() { return check::run(); }
