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
  wide.turned[i] = one.turned;
  set_lane(wide.radiance, i, one.radiance);
  set_lane(wide.receiver, i, one.receiver), set_lane(wide.wi, i, one.wi), set_lane(wide.point, i, one.point);
  set_lane(wide.u, i, one.u), wide.pmf[i] = one.pmf;
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

/// All that a light gives for a case. Only lights that have a front have densities.
template <class Real>
struct Answer {
  LightSample<Real> sample;
  Mask<Real> has_value, faces = false;
  Real pdf = 0, pdf_direction = 0;
};

template <class Light, class Real>
Answer<Real> answer(const Light& light, const Case<Real>& c) {
  const auto sample = sampled(light, c);
  Answer<Real> answer{*sample, sample.has_value()};
  if constexpr (requires { light.faces(c.receiver); })
    answer.faces = light.faces(c.receiver), answer.pdf = light.pdf(c.receiver, c.wi, c.point),
    answer.pdf_direction = light.pdf_direction(c.receiver, c.wi);
  return answer;
}

bool agrees(const Answer<Floats>& wide, std::size_t i, const Answer<float>& one) {
  return wide.has_value[i] == one.has_value && (!one.has_value || same_sample(wide.sample, i, one.sample)) &&
         wide.faces[i] == one.faces && same(wide.pdf[i], one.pdf) && same(wide.pdf_direction[i], one.pdf_direction);
}

/// `make` makes a light of a case, of lanes or of one path.
template <class Make>
void check_light(Make&& make) {
  using Light = decltype(make(Case<float>{}));
  static_assert(kHasLanes<Light>);
  Random random(1);
  const NextLane next = check_lanes<Case>(
      500, [&] { return random_case(random); }, [&](const auto& c) { return answer(make(c), c); });
  CHECK(next.differs > 500);
  CHECK(next.parts > 100 || !requires(Light light, Vec3f p) { light.faces(p); });
}

TEST("lanes of a triangle have the bits of one path") {
  check_light([]<class Real>(const Case<Real>& c) {
    return triangle_light<Real>(Vec3<Real>(c.at), Vec3<Real>(c.at + c.x), Vec3<Real>(c.at + c.y), c.radiance);
  });
}

TEST("lanes of a rectangle have the bits of one path") {
  check_light([]<class Real>(const Case<Real>& c) {
    return rectangle_light<Real>(Vec3<Real>(c.at), c.x, c.y, c.turned, c.radiance);
  });
}

TEST("lanes of a point and of a direction have the bits of one path") {
  check_light([]<class Real>(const Case<Real>& c) { return PointLight<Real>{Vec3<Real>(c.at), c.radiance}; });
  check_light([]<class Real>(const Case<Real>& c) { return DirectionalLight<Real>{c.wi, c.radiance}; });
}

/// A point, which every case has.
template <class Real>
struct Moved {
  Vec3<Real> p;
  Mask<Real> has_value = true;
};
bool agrees(const Moved<Floats>& wide, std::size_t i, const Moved<float>& one) { return same(lane(wide.p, i), one.p); }

TEST("lanes of a point off a surface have the bits of one path") {
  Random random(2);
  const NextLane next = check_lanes<Case>(
      500, [&] { return random_case(random); },
      []<class Real>(const Case<Real>& c) {
        return Moved<Real>{OffsetPoint<Real>{c.point, c.wi, point_offset(c.point, c.wi)}.moved(c.turned)};
      });
  CHECK(next.differs == 2000);
}

}  // namespace

int main() { return check::run(); }
