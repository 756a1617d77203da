// One build, one image: no bit of it depends on threads, tiles, passes, crop, interruption or the kernel that was
// chosen.
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "equaltime/analysis/replay.h"
#include "equaltime/scene/derive_effects.h"
#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace scenes;

constexpr Technique kTechniques[] = {Technique::uniform, Technique::bsdf, Technique::light, Technique::mis,
                                     Technique::mixture};
constexpr std::uint64_t kSamples = 21;  // more than one internal pass, and odd: replicates of different counts

Settings deep() {
  Settings s;
  s.max_depth = 8;
  s.roulette_depth = 3;
  return s;
}

TEST("threads, tiles and pass splits leave every bit where it is") {
  const auto scene = built(in_motion(full_room()));
  const Moments reference = rendered(scene, kSamples, deep(), {.seed = 5, .threads = 1, .tile = 1000});
  CHECK(mean(reference) > 0.01);
  const std::vector<std::vector<std::uint64_t>> splits = {{kSamples}, {1, 2, 3, 20, kSamples}, {17, kSamples}};
  for (const unsigned threads : {1U, 2U, 3U, 7U})
    for (const std::uint32_t tile : {1U, 5U, 16U, 64U})
      for (const auto& split : splits) {
        Renderer renderer(scene, deep(), {.seed = 5, .threads = threads, .tile = tile});
        for (const std::uint64_t samples : split) CHECK(renderer.advance(samples));
        CHECK(same_bits(renderer.film().moments(), reference));
      }
}

TEST("another seed, or one sample more, does change bits") {
  const auto scene = built(full_room());
  const Moments reference = rendered(scene, kSamples, deep());
  CHECK(!same_bits(rendered(scene, kSamples, deep(), {.seed = 1}), reference));
  CHECK(!same_bits(rendered(scene, kSamples + 1, deep()), reference));
}

TEST("every sampler and every technique repeat their bits") {
  const auto scene = built(full_room());
  for (const SamplerKind sampler :
       {SamplerKind::independent, SamplerKind::stratified, SamplerKind::sobol, SamplerKind::lattice})
    for (const Technique technique : kTechniques) {
      Settings settings = deep();
      settings.sampler = sampler, settings.technique = technique;
      CHECK(same_bits(rendered(scene, 5, settings, {.threads = 3, .tile = 3}), rendered(scene, 5, settings)));
    }
}

TEST("a crop has the bits of the whole") {
  SceneDescription description = full_room();
  const Moments whole = rendered(built(description), 6, deep());
  FilmDescription& film = description.film;
  film.crop_x = 7, film.crop_y = 3, film.crop_width = 11, film.crop_height = 9;
  const Moments crop = rendered(built(description), 6, deep());
  CHECK(crop.size() == 2 * 11 * 9);
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t y = 0; y < 9; ++y)
      CHECK(std::memcmp(&crop[(r * 9 + y) * 11], &whole[(r * film.height + y + 3) * film.width + 7],
                        11 * sizeof(PixelMoments)) == 0);
}

TEST("every kernel that covers a scene gives the same bits") {
  for (const LightSelection lights : {LightSelection::power, LightSelection::tree})
    for (const Technique technique : kTechniques)
      for (const SceneDescription& description :
           {room(), room_of_curves(), in_vacuum(full_room()), full_room(), in_motion(room()), in_motion(full_room()),
            hiding(room()), hiding(in_vacuum(full_room())), hiding(in_motion(full_room()))}) {
        const auto scene = built(description);
        Settings settings = deep();
        settings.light_selection = lights, settings.technique = technique;
        const Moments reference = rendered(scene, 6, settings);
        int covering = 0;
        for (const Kernel& kernel : compiled_kernels()) {
          if (!kernel.effects.covers(derive_effects(*scene))) continue;
          ++covering;
          Film film(scene->camera.film.crop_width, scene->camera.film.crop_height, 2);
          RayCounter probe;
          SampleLog<NonFinite> nonfinite;
          kernel.render({*scene, settings, 0, {0, 0, film.width(), film.height()}, 0, 6}, film, probe, nonfinite);
          CHECK(same_bits(film.moments(), reference));
        }
        CHECK(covering >= 1);
      }
}

TEST("what shines is seen or not: bits tell") {
  for (const SceneDescription& description : {room(), full_room()})
    CHECK(!same_bits(rendered(built(hiding(description)), 2, deep()), rendered(built(description), 2, deep())));
}

/// What a path's vertices add, one after the other.
Spectrum sum(const Replay& path) {
  Spectrum total;
  for (const TracedVertex& vertex : path.vertices) {
    CHECK(vertex.L == total);
    if (vertex.emitter) total += vertex.emitter->gathered;
    if (vertex.light) total += vertex.light->gathered;
  }
  return total * path.filter_weight;
}

TEST("replays of all samples are the film, bit by bit, and what they list sums up to each") {
  for (const LightSelection lights : {LightSelection::power, LightSelection::tree})
    for (const Technique technique : kTechniques)
      for (const SceneDescription& description :
           {room(), room_of_curves(), full_room(), in_motion(full_room()), hiding(in_motion(full_room()))}) {
        const auto scene = built(description);
        Settings settings = deep();
        settings.light_selection = lights, settings.technique = technique;
        Film film(scene->camera.film.crop_width, scene->camera.film.crop_height, 2);
        const double scale = scene->normalization.world_radiance_scale();
        for (std::uint32_t y = 0; y < film.height(); ++y)
          for (std::uint32_t x = 0; x < film.width(); ++x)
            for (std::uint64_t i = 0; i < 5; ++i) {
              const Replay path = replay(*scene, settings, 3, x, y, i, 2);
              CHECK(sum(path) == path.radiance);
              film.at(i % 2, x, y).add(path.radiance, scale);
            }
        CHECK(same_bits(film.moments(), rendered(scene, 5, settings, {.seed = 3})));
      }
}

TEST("a cheaper kernel is chosen for the plain room than for the full one") {
  CHECK(!choose_kernel(derive_effects(*built(room()))).effects.environment);
  Effects all = kAllEffects;
  all.splitting = false;  // no scene calls for it
  CHECK(choose_kernel(derive_effects(*built(full_room()))).effects == all);
}

TEST("media of no extinction call for nothing, and leave no bit elsewhere") {
  SceneDescription bare = full_room();
  for (ShapeDescription& shape : bare.shapes)
    std::visit(
        [](auto& any) {
          if constexpr (requires { any.surface; }) any.surface.exterior = any.surface.interior = {};
        },
        shape);
  bare.media.clear(), bare.camera_medium = {};
  const auto vacuum = built(in_vacuum(full_room()));
  CHECK(!derive_effects(*vacuum).media && derive_effects(*built(full_room())).media);
  CHECK(same_bits(rendered(vacuum, 6, deep()), rendered(built(bare), 6, deep())));
  CHECK(!same_bits(rendered(built(full_room()), 6, deep()), rendered(vacuum, 6, deep())));
}

TEST("surfaces of nothing may be vertices of paths or none, with every technique") {
  SceneDescription description = full_room();
  description.count_null_interfaces = false;
  for (const Technique technique : kTechniques) {
    Settings settings = deep();
    settings.technique = technique;
    const auto scene = built(description);
    CHECK(same_bits(rendered(scene, 5, settings, {.threads = 3, .tile = 3}), rendered(scene, 5, settings)));
    CHECK(!same_bits(rendered(scene, 5, settings), rendered(built(full_room()), 5, settings)));
  }
}

TEST("counters count: a path a sample, and no ray without need") {
  const auto scene = built(room());
  Renderer renderer(scene, deep(), {.threads = 2});
  renderer.advance(4);
  const std::uint64_t paths = 4ULL * 33 * 26;
  CHECK(renderer.counters().paths == paths);
  CHECK(renderer.counters().rays > paths && renderer.counters().rays <= 8 * paths);
  CHECK(renderer.counters().shadow_rays > 0 && renderer.counters().nonfinite == 0);
}

TEST("a mixture sends one ray a vertex and none for a shadow, and rays of uniform directions look for no light") {
  const auto scene = built(room());
  const auto count = [&](Technique technique) {
    Settings settings;
    settings.technique = technique, settings.max_depth = 2;
    Renderer renderer(scene, settings, {});
    renderer.advance(16);
    return renderer.counters();
  };
  const Counters mis = count(Technique::mis), mixture = count(Technique::mixture), uniform = count(Technique::uniform);
  CHECK(uniform.shadow_rays == 0);
  CHECK(mixture.shadow_rays == 0);
  // At one vertex of a path, a BSDF sample always sends a ray, and a light sample sends none from behind the emitter.
  CHECK(mixture.rays <= mis.rays && 10 * (mis.rays - mixture.rays) < mis.rays - mis.paths);
}

}  // namespace

int main() { return check::run(); }
