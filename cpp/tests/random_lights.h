// Lights and receivers at random, for tests of the light tree.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <variant>
#include <vector>

#include "equaltime/sampling/warps.h"
#include "equaltime/scene/lights.h"

namespace random_scene {

using namespace equaltime;

using AnyLight = std::variant<TriangleLight<float>, RectangleLight<float>, SphereLight, DiskLight, PointLight<float>,
                              SpotLight, CylinderLight>;

struct Random {
  explicit Random(std::uint64_t seed) : engine(seed) {}
  double in(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine); }
  std::int64_t place() { return static_cast<std::int64_t>(engine() >> (64 - LightTree::kUnitBits)); }
  Vec3d direction() {
    const Point2f u{static_cast<float>(in(0, 1)), static_cast<float>(in(0, 1))};
    return normalize(Vec3d(square_to_uniform_sphere(u)));
  }
  Vec3d point(double reach) { return {in(-reach, reach), in(-reach, reach), in(-reach, reach)}; }

  std::mt19937_64 engine;
};

inline AnyLight random_light(Random& random, double size, double decades) {
  const Vec3d at = random.point(1);
  const Spectrum radiance(static_cast<float>(std::pow(10, random.in(-decades, decades))));
  const Vec3d x = random.direction() * size, y = normalize(cross(x, random.direction())) * (size * random.in(0.1, 1));
  switch (random.engine() % 7) {
    case 0:
      return triangle_light(Vec3f(at), Vec3f(at + x), Vec3f(at + random.direction() * size), radiance);
    case 1:
      return rectangle_light(Vec3f(at), x, y, random.engine() % 2 == 0, radiance);
    case 2:
      return SphereLight(at, size, random.engine() % 2 == 0, radiance);
    case 3:
      return DiskLight(at, x, y, random.engine() % 2 == 0, radiance);
    case 4: {
      const double cutoff = random.in(0.01, 3.14);
      return SpotLight(Vec3f(at), random.direction(), radiance, cutoff, cutoff * random.in(0, 1));
    }
    case 5:
      return CylinderLight({at, normalize(x), size * random.in(0.1, 4), size}, random.engine() % 2 == 0, radiance);
    default:
      return PointLight<float>{Vec3f(at), radiance};
  }
}

inline std::vector<AnyLight> random_lights(Random& random, std::size_t n, double size = 0.1, double decades = 1) {
  std::vector<AnyLight> lights;
  while (lights.size() < n) lights.push_back(random_light(random, size, decades));
  return lights;
}

inline std::vector<LightBounds> bounds_of(const std::vector<AnyLight>& lights) {
  std::vector<LightBounds> bounds;
  for (const AnyLight& light : lights) bounds.push_back(std::visit([](const auto& l) { return l.bounds(); }, light));
  return bounds;
}

inline LightTree tree_of(const std::vector<AnyLight>& lights) { return LightTree(bounds_of(lights)); }

inline LightSampleContext random_receiver(Random& random, double reach = 1.5) {
  return {Vec3f(random.point(reach)), Vec3f(random.direction()), random.engine() % 4 != 0};
}

/// A sample of the light, with probability 1 of the pick.
inline Optional<LightSample<float>> sampled(const AnyLight& light, Vec3f receiver, Point2f u) {
  if (const auto* point = std::get_if<PointLight<float>>(&light)) return point->sample(receiver, 1);
  if (const auto* spot = std::get_if<SpotLight>(&light)) return spot->sample(receiver, 1);
  if (const auto* cylinder = std::get_if<CylinderLight>(&light)) return cylinder->sample(receiver, u, 1);
  if (const auto* triangle = std::get_if<TriangleLight<float>>(&light)) return triangle->sample(receiver, u, 1);
  if (const auto* rectangle = std::get_if<RectangleLight<float>>(&light)) return rectangle->sample(receiver, u, 1);
  if (const auto* sphere = std::get_if<SphereLight>(&light)) return sphere->sample(receiver, u, 1);
  return std::get<DiskLight>(light).sample(receiver, u, 1);
}

}  // namespace random_scene
