// The light tree: its probabilities are those of its choices, none is 0 where light may come from, and neither places,
// powers nor orders of lights can break it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <variant>
#include <vector>

#include "tests/check.h"
#include "tests/random_lights.h"
#include "tests/statistics.h"

namespace {

using namespace random_scene;

double sum_of_pmfs(const LightTree& tree, const LightSampleContext& receiver, std::size_t lights) {
  double sum = 0;
  for (std::uint32_t i = 0; i < lights; ++i) sum += static_cast<double>(tree.pmf(receiver, i));
  return sum;
}

/// How many lights light their receivers, and how many of these can never be picked.
struct Seen {
  int lit = 0, lost = 0;
};

/// Receivers are made so that the bounds are tight: they look along the light, or stand in its plane.
Seen look_for_lost_light(const std::vector<AnyLight>& lights, const LightTree& tree, int rounds) {
  Random random(11);
  Seen seen;
  for (int round = 0; round < rounds; ++round) {
    LightSampleContext receiver = random_receiver(random);
    const auto light = static_cast<std::uint32_t>(random.engine() % lights.size());
    const double tiny = std::pow(10, random.in(-8, 0));
    const Point2f u{static_cast<float>(random.in(0, 1)), static_cast<float>(random.in(0, 1))};
    const LightBounds bounds = std::visit([](const auto& l) { return l.bounds(); }, lights[light]);
    if (round % 3 == 1) {
      const Vec3d aside = normalize(cross(bounds.normals.axis, random.direction()));
      const double away = bounds.radius * std::pow(10, random.in(-1, 4));
      receiver.p = Vec3f(bounds.box.center() + aside * away + bounds.normals.axis * (tiny * away));
    }
    auto sample = sampled(lights[light], receiver.p, u);
    if (!sample) continue;
    if (round % 3 != 0) {
      const Vec3d wi(sample->wi), across = normalize(cross(wi, random.direction()));
      receiver.n = Vec3f(normalize(across + wi * tiny));
    }
    if (receiver.opaque && !(dot(receiver.n, sample->wi) > 0)) continue;
    if (sample->radiance.is_black()) continue;
    ++seen.lit;
    if (!(tree.pmf(receiver, light) > 0)) ++seen.lost;
  }
  return seen;
}

TEST("the probabilities of all lights sum to 1 for a receiver that all of them may reach") {
  Random random(1);
  for (const std::size_t n : {1UL, 2UL, 3UL, 17UL, 300UL}) {
    std::vector<AnyLight> lights;
    for (std::size_t i = 0; i < n; ++i)
      lights.push_back(PointLight<float>{Vec3f(random.point(1)), Spectrum(static_cast<float>(random.in(0.1, 9)))});
    const LightTree tree = tree_of(lights);
    for (int round = 0; round < 100; ++round) {
      LightSampleContext receiver = random_receiver(random);
      receiver.opaque = false;
      CHECK(std::abs(sum_of_pmfs(tree, receiver, n) - 1) < 1e-6);
    }
  }
}

TEST("they never sum to more, and what is missing is how often nothing is picked") {
  Random random(2);
  constexpr int kDraws = 4000;
  for (int round = 0; round < 100; ++round) {
    const std::vector<AnyLight> lights = random_lights(random, 1 + random.engine() % 30);
    const LightTree tree = tree_of(lights);
    const LightSampleContext receiver = random_receiver(random);
    const double sum = sum_of_pmfs(tree, receiver, lights.size());
    CHECK(sum < 1 + 1e-6);
    int picked = 0;
    for (int i = 0; i < kDraws; ++i) picked += tree.pick(receiver, random.place()).has_value();
    CHECK(std::abs(picked - sum * kDraws) <= 5 * std::sqrt(kDraws * std::max(sum * (1 - sum), 1e-6)) + 1e-2);
  }
}

TEST("the probability of a light that was hit is that of picking it, to the last bit") {
  Random random(3);
  for (const double decades : {0.0, 20.0}) {
    const std::vector<AnyLight> lights = random_lights(random, 1000, 0.05, decades);
    const LightTree tree = tree_of(lights);
    int picks = 0;
    for (int i = 0; i < 50000; ++i) {
      const LightSampleContext receiver = random_receiver(random);
      const auto pick = tree.pick(receiver, random.place());
      if (!pick) continue;
      ++picks;
      CHECK(pick->pmf > 0 && pick->pmf == tree.pmf(receiver, pick->light));
    }
    CHECK(picks > 25000);
  }
}

TEST("a light's probability is exactly its share of the numbers, for powers over forty decades") {
  Random random(4);
  std::vector<AnyLight> lights;
  for (int i = 0; i < 60; ++i)
    lights.push_back(
        PointLight<float>{Vec3f(random.point(1)), Spectrum(static_cast<float>(std::pow(10, random.in(-20, 20))))});
  const LightTree tree = tree_of(lights);
  for (int round = 0; round < 20; ++round) {
    LightSampleContext receiver = random_receiver(random);
    receiver.opaque = false;
    std::size_t found = 0;
    for (std::int64_t begin = 0; begin < LightTree::kUnits; ++found) {
      const auto pick = tree.pick(receiver, begin);
      std::int64_t low = begin, high = LightTree::kUnits;  // this light at low, another at high
      while (high - low > 1) {
        const std::int64_t middle = low + (high - low) / 2;
        (tree.pick(receiver, middle)->light == pick->light ? low : high) = middle;
      }
      CHECK(pick->pmf == static_cast<float>(high - begin) / static_cast<float>(LightTree::kUnits));
      begin = high;
    }
    CHECK(found == lights.size());  // the dimmest have a place of their own too
  }
}

TEST("no light that lights a receiver is ever left out") {
  Random random(5);
  for (const double size : {1e-6, 0.01, 0.3, 2.0})
    for (const double decades : {0.0, 20.0})
      for (const std::size_t n : {1UL, 2UL, 5UL, 200UL}) {
        const std::vector<AnyLight> lights = random_lights(random, n, size, decades);
        const Seen seen = look_for_lost_light(lights, tree_of(lights), 3000);
        CHECK(seen.lost == 0);
        CHECK(seen.lit > 100);
      }
}

TEST("the same search finds light lost by a cone half a degree off, and by a sphere a twentieth too small") {
  // The twin of the test above.
  Random random(6);
  const std::vector<AnyLight> lights = random_lights(random, 50, 0.3);
  std::vector<LightBounds> tilted = bounds_of(lights), shrunk = tilted;
  for (LightBounds& b : tilted) {
    const Vec3d across = normalize(cross(b.normals.axis, random.direction()));
    b.normals.axis = normalize(b.normals.axis + across * 0.0087);
  }
  for (LightBounds& b : shrunk) b.radius *= 0.95;
  CHECK(look_for_lost_light(lights, LightTree(tilted), 30000).lost > 0);
  CHECK(look_for_lost_light(lights, LightTree(shrunk), 30000).lost > 0);
}

TEST("choices follow the probabilities by a chi-squared test, which sees two percent") {
  Random random(7);
  std::vector<AnyLight> lights = random_lights(random, 20, 0.1, 0.3);
  const LightTree tree = tree_of(lights);
  constexpr int kDraws = 2000000;
  const LightSampleContext receiver{{0.1F, 0.2F, 0.3F}, {0, 0, 1}, true};
  std::vector<double> counts(lights.size() + 1, 0), expected;
  for (int i = 0; i < kDraws; ++i) {
    const auto pick = tree.pick(receiver, random.place());
    ++counts[pick ? pick->light : lights.size()];
  }
  const auto deviate = [&](double tilt) {
    std::vector<double> seen, meant;
    double rest = 1;
    for (std::uint32_t i = 0; i < lights.size(); ++i) {
      const double p = static_cast<double>(tree.pmf(receiver, i));
      rest -= p;
      CHECK(p > 0 || counts[i] == 0);
      if (p * kDraws > 5) seen.push_back(counts[i]), meant.push_back(p * kDraws);
    }
    if (rest * kDraws > 5) seen.push_back(counts[lights.size()]), meant.push_back(rest * kDraws);
    *std::max_element(meant.begin(), meant.end()) *= tilt;
    return statistics::chi_squared_deviate(seen, meant);
  };
  CHECK(std::abs(deviate(1)) < statistics::kReject);
  CHECK(deviate(1.02) > statistics::kReject);
}

TEST("lights in one place, on a line, in one plane and of one normal all get their turn") {
  const Spectrum white(1);
  std::vector<std::vector<AnyLight>> worlds(4);
  for (int i = 0; i < 100; ++i) {
    const auto x = static_cast<float>(i);
    worlds[0].push_back(PointLight<float>{{1, 2, 3}, white});
    worlds[1].push_back(PointLight<float>{{x, 2 * x, -x}, white});
    worlds[2].push_back(triangle_light<float>({x, 0, 0}, {x + 1, 0, 0}, {x, 0, 1}, white));
    worlds[3].push_back(SphereLight({0, 0, 0}, 1, i % 2 == 0, white));
  }
  Random random(8);
  for (const std::vector<AnyLight>& lights : worlds) {
    const LightTree tree = tree_of(lights);
    CHECK(look_for_lost_light(lights, tree, 3000).lost == 0);
    const LightSampleContext receiver{{1.5F, -0.5F, 0.25F}, {0, 1, 0}, false};
    CHECK(std::abs(sum_of_pmfs(tree, receiver, lights.size()) - 1) < 1e-6);
  }
}

TEST("a receiver at a light's place, or within a cluster, may pick any light") {
  Random random(9);
  const std::vector<AnyLight> lights = random_lights(random, 40);
  const std::vector<LightBounds> bounds = bounds_of(lights);
  const LightTree tree(bounds);
  for (std::uint32_t i = 0; i < lights.size(); ++i) {
    const LightSampleContext receiver{Vec3f(bounds[i].box.center()), Vec3f(random.direction()), true};
    CHECK(tree.pmf(receiver, i) > 0);
    CHECK(std::isfinite(sum_of_pmfs(tree, receiver, lights.size())));
  }
}

TEST("a light too far for the square of its distance takes none from those nearby") {
  std::vector<AnyLight> lights = {
      PointLight<float>{{1e30F, 0, 0}, Spectrum(1e30F)}, PointLight<float>{{1, 0, 0}, Spectrum(1)},
      PointLight<float>{{-1e30F, 0, 0}, Spectrum(1e30F)}, PointLight<float>{{0, 1, 0}, Spectrum(1)}};
  const LightTree tree = tree_of(lights);
  for (const Vec3f n : {Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0.6F, 0.8F, 0}}) {
    const LightSampleContext receiver{{0, 0, 0}, n, true};
    CHECK(std::abs(sum_of_pmfs(tree, receiver, lights.size()) - 1) < 1e-6);
    CHECK(n.x == 0 || tree.pmf(receiver, 1) > 0);
    CHECK(n.y == 0 || tree.pmf(receiver, 3) > 0);
  }
}

TEST("a light that never shines is never picked, and no light at all leaves the tree empty") {
  std::vector<LightBounds> bounds =
      bounds_of({PointLight<float>{{0, 0, 0}, Spectrum(1)}, PointLight<float>{{1, 0, 0}, Spectrum(0)},
                 PointLight<float>{{2, 0, 0}, Spectrum(2)}});
  const LightTree tree(bounds);
  const LightSampleContext receiver{{0, 1, 0}, {0, -1, 0}, true};
  CHECK(tree.pmf(receiver, 1) == 0 && tree.pmf(receiver, 0) > 0 && tree.pmf(receiver, 2) > 0);
  bounds[0].intensity = bounds[2].intensity = 0;
  CHECK(LightTree(bounds).empty() && !LightTree(bounds).pick(receiver, 0) && !LightTree(bounds).may_light(receiver));
  CHECK(LightTree(std::vector<LightBounds>{}).empty());
}

TEST("no order of places makes the tree deeper than a trail is long") {
  for (const double ratio : {0.5, 0.9, 1.5, 2.0}) {
    std::vector<AnyLight> lights;
    for (int i = 0; i < 3000; ++i) {
      const double at = std::pow(ratio, i % 120), power = std::pow(ratio, -(i % 60));
      lights.push_back(PointLight<float>{{static_cast<float>(at), 0, 0}, Spectrum(static_cast<float>(power))});
    }
    const LightTree tree = tree_of(lights);
    CHECK(tree.depth() <= 63 && tree.depth() >= 12);
    CHECK(look_for_lost_light(lights, tree, 2000).lost == 0);
  }
}

TEST("lengths and powers times a power of two change no bit of any choice") {
  Random random(10);
  const std::vector<LightBounds> bounds = bounds_of(random_lights(random, 500));
  const LightTree tree(bounds);
  for (const double s : {0x1p-20, 0x1p20})
    for (const double l : {0x1p-20, 1.0, 0x1p20}) {
      std::vector<LightBounds> scaled = bounds;
      for (LightBounds& b : scaled) {
        b.box = {b.box.lo * s, b.box.hi * s};
        b.radius *= s, b.intensity *= l;
      }
      const LightTree other(scaled);
      for (int i = 0; i < 3000; ++i) {
        const LightSampleContext receiver = random_receiver(random);
        const std::int64_t place = random.place();
        const auto a = tree.pick(receiver, place);
        const auto b = other.pick({receiver.p * static_cast<float>(s), receiver.n, receiver.opaque}, place);
        CHECK(a.has_value() == b.has_value());
        if (a && b) CHECK(a->light == b->light && a->pmf == b->pmf);
      }
    }
}

TEST("next to one of a thousand lights, that one is picked more often than if all were alike") {
  Random random(12);
  std::vector<AnyLight> lights;
  for (int i = 0; i < 1000; ++i) lights.push_back(PointLight<float>{Vec3f(random.point(1)), Spectrum(1)});
  const LightTree tree = tree_of(lights);
  for (std::uint32_t i = 0; i < 1000; i += 50) {
    const Vec3f place = std::get<PointLight<float>>(lights[i]).position;
    CHECK(tree.pmf({place + Vec3f{0.001F, 0, 0}, {-1, 0, 0}, true}, i) > 0.005F);
  }
}

}  // namespace

int main() { return check::run(); }
