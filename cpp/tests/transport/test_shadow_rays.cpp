// Which query a shadow ray is: whether anything is in its way, unless something there may let light pass.
#include "equaltime/transport/sample_pixel.h"
#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace equaltime;

struct QueryCounter : PathObserver {
  int nearest = 0, any = 0;

  void on(const event::ShadowRayTraced&) noexcept { ++any; }
  void on(const event::ShadowRayHit&) noexcept { ++nearest; }
};

QueryCounter queries_of(SceneDescription description) {
  const Scene scene = build_scene(std::move(description));
  const Settings settings;
  const BlockTask task{scene, settings, 1, {0, 0, 33, 26}, 0, 1, 1};
  QueryCounter counter;
  for (std::uint32_t x = 0; x < 33; ++x) (void)sample_pixel<kAllEffects>(task, x, 13, 0, counter);
  return counter;
}

}  // namespace

TEST("where nothing lets light pass, shadow rays look for anything in their way, but in media for the nearest") {
  const QueryCounter plain = queries_of(scenes::room());
  CHECK(plain.any > 0 && plain.nearest == 0);
  SceneDescription fog = scenes::room();
  fog.media.push_back({{0.1, 0.1, 0.1}, {0.5, 0.5, 0.5}});
  fog.camera_medium = 0;
  const QueryCounter thick = queries_of(std::move(fog));
  CHECK(thick.any == 0 && thick.nearest > 0);  // how far it is counts, to more digits than Embree has
}

TEST("where something may let light pass, they look for the nearest") {
  SceneDescription masked = scenes::room();
  masked.bsdfs.emplace_back(NullDescription{});
  std::get<RectangleDescription>(masked.shapes[2]).surface.front = 2;
  const QueryCounter counter = queries_of(std::move(masked));
  CHECK(counter.nearest > 0 && counter.any == 0);
}

int main() { return check::run(); }
