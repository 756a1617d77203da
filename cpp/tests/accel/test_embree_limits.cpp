// Rays that Embree does not take: Debian builds it with assertions, and any of them would end the process.
#include <limits>
#include <vector>

#include "equaltime/accel/accel.h"
#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace equaltime;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

Geometries triangle() { return {{{{{-3, -3, 1}, {3, -3, 1}, {0, 3, 1}}, {{0, 1, 2}}}}}; }
Geometries ball() {
  Geometries ball;
  ball.of<Sphere<float>>() = {{{0, 0, 1}, 0.5}};
  return ball;
}

/// A group that is seen once, `scale` times as large.
std::vector<InstanceGeometry> seen(float scale) { return {{0, {scale, 0, 0, 0, scale, 0, 0, 0, scale, 0, 0, 0}}}; }

std::vector<Ray> refused_rays() {
  std::vector<Ray> rays;
  for (const float wrong : {kNaN, kInf, -kInf, 1e30F, -1.9e18F, 3.4e38F}) {
    rays.push_back({{wrong, 0, 0}, {0, 0, 1}});
    rays.push_back({{0, 0, wrong}, {0, 0, 1}});
    rays.push_back({{0, 0, 0}, {0, wrong, 1}});
  }
  return rays;
}

TEST("a ray that Embree does not take meets nothing, and is told of once") {
  const Accel plain(triangle()), instanced(triangle(), Intersection::robust, {ball()}, seen(1));
  const Accel moving(triangle(), Intersection::robust, {ball()}, {}, {{0, Motion(scenes::swing({}, {1, 0, 0}, 1))}});
  for (const Ray& ray : refused_rays()) {
    CHECK(!plain.closest(ray) && Accel::take_refusal() && !Accel::take_refusal());
    CHECK(!instanced.closest(ray) && Accel::take_refusal());
    CHECK(!moving.closest(ray, 0.5F) && Accel::take_refusal());
    CHECK(plain.occluded(ray) && Accel::take_refusal());
    CHECK(moving.occluded(ray, 0.5F) && Accel::take_refusal());
  }
}

TEST("rays within the limits are met as ever, and nothing is told") {
  const Accel plain(triangle()), instanced(triangle(), Intersection::robust, {ball()}, seen(1));
  for (const Ray& ray : {Ray{{0, 0, 0}, {0, 0, 1}}, Ray{{0, 0, 0}, {0, 0, 1e12F}}, Ray{{0, 0, -1e6F}, {0, 0, 1}}}) {
    CHECK(plain.closest(ray) && plain.occluded(ray) && instanced.closest(ray));
    CHECK(!Accel::take_refusal());
  }
}

TEST("a group that is seen squeezed takes rays as far as its own space is within the limits") {
  for (const float scale : {1e-3F, 1e-9F, 1e-13F}) {
    const double reach = Accel::reach(seen(scale)[0]);
    CHECK(reach > 1e18 * 0.5 * static_cast<double>(scale) && reach < 1.8e18 * static_cast<double>(scale));
    const Accel accel(triangle(), Intersection::robust, {ball()}, seen(scale));
    const float far = static_cast<float>(reach), z = scale;
    CHECK(!accel.closest({{0, 0, -1.01F * far}, {0, 0, 1}}) && Accel::take_refusal());
    static_cast<void>(accel.closest({{0, 0, -0.99F * far}, {0, 0, 1}}));
    CHECK(!Accel::take_refusal());
    CHECK(accel.closest({{0, 0, -z}, {0, 0, 1}}).has_value());
  }
  for (const float scale : {0.0F, 1e-20F, 1e-38F, 1e-45F}) CHECK(Accel::reach(seen(scale)[0]) == 0);
}

TEST("a moving group that is squeezed to nothing ends no process") {
  for (const double size : {1e-17, 1e-20, 1e-30}) {
    std::vector<MovingInstanceGeometry> moving{{0, Motion(scenes::swing({}, {1, 0, 0}, size))}};
    const Accel accel(triangle(), Intersection::robust, {ball()}, {}, std::move(moving));
    static_cast<void>(accel.closest({{0, 0, -1}, {0, 0, 1}}, 0));
    static_cast<void>(accel.occluded({{0, 0, -1}, {0, 0, 1}}, 0));
    static_cast<void>(Accel::take_refusal());
  }
}

}  // namespace

int main() { return check::run(); }
