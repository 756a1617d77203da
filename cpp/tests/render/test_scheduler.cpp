// Blocks, workers and interruptions: many small blocks over more threads than processors, stopped in every way there
// is and taken up again. Written to be run under ThreadSanitizer too.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <stop_token>
#include <string>
#include <thread>

#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace scenes;

constexpr std::uint64_t kSamples = 18;
constexpr RenderOptions kMany{.seed = 3, .threads = 7, .tile = 2};

Settings shallow() {
  Settings s;
  s.max_depth = 4;
  return s;
}

const std::shared_ptr<const Scene>& scene() {
  static const auto shared = built(full_room());
  return shared;
}
const Moments& reference() {
  static const Moments moments = rendered(scene(), kSamples, shallow(), {.seed = 3, .threads = 1, .tile = 64});
  return moments;
}

// Whether a render that was cut ends between blocks: the pixels of a block have equally many samples, and no block has
// more than those before it.
bool ends_between_blocks(Renderer& renderer) {
  const Film& film = renderer.film();
  const auto count = [&](std::uint32_t x, std::uint32_t y) { return film.at(0, x, y).count + film.at(1, x, y).count; };
  std::uint64_t before = std::numeric_limits<std::uint64_t>::max();
  for (const PixelBlock& b : renderer.blocks()) {
    const std::uint64_t here = count(b.x0, b.y0);
    for (std::uint32_t y = b.y0; y < b.y1; ++y)
      for (std::uint32_t x = b.x0; x < b.x1; ++x)
        if (count(x, y) != here) return false;
    if (here > before) return false;
    before = here;
  }
  return true;
}

TEST("many small blocks on many threads give the image of one thread") {
  CHECK(same_bits(rendered(scene(), kSamples, shallow(), kMany), reference()));
}

TEST("a time limit cuts between blocks, and the next calls finish the same image") {
  Renderer renderer(scene(), shallow(), kMany);
  int cuts = 0;
  while (!renderer.advance(kSamples, cuts < 200 ? 1e-4 : 1e9)) {
    ++cuts;
    CHECK(ends_between_blocks(renderer));
  }
  CHECK(cuts > 0);
  CHECK(same_bits(renderer.film().moments(), reference()));
  CHECK(renderer.counters().paths == kSamples * renderer.film().width() * renderer.film().height());
}

TEST("a render taken up from its moments, cut anywhere, has the bits of one that was never cut") {
  int cuts = 0;
  for (double seconds = 1e-5; seconds < 1; seconds *= 1.7) {
    Renderer first(scene(), shallow(), kMany);
    if (!first.advance(kSamples, seconds)) ++cuts;
    Renderer second(scene(), shallow(), kMany);
    second.film().moments() = first.film().moments();
    second.resume(first.counters(), first.position());
    CHECK(second.advance(kSamples));
    CHECK(same_bits(second.film().moments(), reference()));
    CHECK(second.counters().paths == kSamples * second.film().width() * second.film().height());
  }
  CHECK(cuts > 0);
}

TEST("moments that no pass leaves are not taken up") {
  Renderer whole(scene(), shallow(), kMany);
  whole.advance(4);
  const auto refused = [&](auto change) {
    Renderer renderer(scene(), shallow(), kMany);
    renderer.film().moments() = whole.film().moments();
    change(renderer.film());
    try {
      renderer.resume(whole.counters(), whole.position());
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  CHECK(!refused([](Film&) {}));
  CHECK(refused([](Film& f) { --f.at(0, 1, 1).count; }));  // within a block
  CHECK(refused([](Film& f) { std::swap(f.at(0, 0, 0).count, f.at(1, 2, 2).count), ++f.at(0, 0, 0).count; }));
  CHECK(refused([](Film& f) {  // a whole block that is behind those after it
    for (std::uint32_t r = 0; r < 2; ++r)
      for (std::uint32_t y = 0; y < 2; ++y)
        for (std::uint32_t x = 0; x < 2; ++x) --f.at(r, x, y).count;
  }));
}

TEST("windows that are rendered one after another, in two steps each, give the image of one render") {
  Renderer renderer(scene(), shallow(), kMany);
  const std::uint32_t width = renderer.film().width(), height = renderer.film().height(), middle = width / 4 * 2;
  for (const PixelBlock& window : {PixelBlock{middle, 0, width, height}, PixelBlock{0, 0, middle, height}}) {
    renderer.limit_to(window);
    CHECK(renderer.advance(8));
    const Moments so_far = renderer.film().moments();
    renderer.limit_to(window);
    renderer.film().moments() = so_far;
    renderer.resume({}, {8, 8, 0});
    CHECK(renderer.advance(kSamples));
    CHECK(renderer.counters().paths == (kSamples - 8) * (window.x1 - window.x0) * height);
  }
  CHECK(same_bits(renderer.film().moments(), reference()));
}

TEST("the counters of a window include the pilot's rays, whether the pilot or the window comes first") {
  Settings settings = shallow();
  settings.roulette = Roulette::efficiency;
  Renderer pilot_first(scene(), settings, kMany), window_first(scene(), settings, kMany);
  const PixelBlock window{0, 0, 4, 4};
  pilot_first.decide();
  pilot_first.limit_to(window), window_first.limit_to(window);
  CHECK(pilot_first.advance(2) && window_first.advance(2));
  const Counters &a = pilot_first.counters(), &b = window_first.counters();
  CHECK(a.paths == 2 * 16 && b.paths == a.paths && a.rays == b.rays && a.shadow_rays == b.shadow_rays);
  CHECK(a.rays > pilot_first.decision()->rays && pilot_first.decision()->rays > 0);
}

TEST("windows that are no whole blocks, or none at all, are refused") {
  Renderer renderer(scene(), shallow(), kMany);
  const auto refused = [&](const PixelBlock& window) {
    try {
      renderer.limit_to(window);
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  CHECK(refused({1, 0, 4, 4}));
  CHECK(refused({0, 0, 3, 4}));
  CHECK(refused({2, 2, 2, 4}));
  CHECK(refused({0, 0, renderer.film().width() + 2, 2}));
  CHECK(!refused({0, 0, renderer.film().width(), 2}));
}

std::vector<float> slanted(const Film& film) {
  std::vector<float> rates(std::size_t{film.width()} * film.height());
  for (std::size_t i = 0; i < rates.size(); ++i)
    rates[i] = 2 * static_cast<float>(i) / static_cast<float>(rates.size());
  return rates;
}

TEST("rates give each pixel its number of samples beyond the pilot, the first of those that it would have had") {
  Renderer renderer(scene(), shallow(), kMany);
  const std::vector<float> rates = slanted(renderer.film());
  const SampleSchedule schedule(4, rates, 2);
  renderer.advance(4);
  renderer.set_sample_rates(4, rates);
  for (int cut = 0; !renderer.advance(kSamples, cut < 50 ? 1e-4 : 1e9); ++cut) {
  }
  for (std::uint32_t y = 0; y < renderer.film().height(); ++y)
    for (std::uint32_t x = 0; x < renderer.film().width(); ++x) {
      const std::uint64_t samples = schedule.count(std::size_t{y} * renderer.film().width() + x, kSamples);
      CHECK(renderer.film().at(0, x, y).count + renderer.film().at(1, x, y).count == samples);
      if (x != y) continue;  // one row's worth is enough to render again
      Renderer even(scene(), shallow(), kMany);
      even.advance(samples);
      CHECK(even.film().at(1, x, y).mean[0] == renderer.film().at(1, x, y).mean[0]);
    }
}

TEST("an uneven render taken up from its moments has the bits of one that was never cut") {
  Renderer whole(scene(), shallow(), kMany);
  const std::vector<float> rates = slanted(whole.film());
  whole.advance(4);
  whole.set_sample_rates(4, rates);
  whole.advance(kSamples);
  for (double seconds = 1e-5; seconds < 1; seconds *= 3) {
    Renderer first(scene(), shallow(), kMany);
    first.advance(4);
    first.set_sample_rates(4, rates);
    first.advance(kSamples, seconds);
    Renderer second(scene(), shallow(), kMany);
    second.film().moments() = first.film().moments();
    second.set_sample_rates(4, rates);
    second.resume(first.counters(), first.position());
    CHECK(second.advance(kSamples));
    CHECK(same_bits(second.film().moments(), whole.film().moments()));
  }
}

TEST("rates that cannot be, or come when samples differ already, are refused") {
  const auto refused = [](std::uint64_t done, std::uint64_t pilot, float rate, std::size_t missing) {
    Renderer renderer(scene(), shallow(), kMany);
    renderer.advance(done);
    try {
      renderer.set_sample_rates(pilot, std::vector<float>(renderer.film().moments().size() / 2 - missing, rate));
    } catch (const std::invalid_argument&) {
      return true;
    }
    return false;
  };
  CHECK(!refused(4, 4, 1, 0));
  CHECK(refused(4, 2, 1, 0));
  CHECK(refused(3, 3, 1, 0));
  CHECK(refused(4, 4, -1, 0));
  CHECK(refused(4, 4, std::numeric_limits<float>::quiet_NaN(), 0));
  CHECK(refused(4, 4, 1, 1));
}

TEST("a copy of a renderer goes on with what was learnt when the first is gone") {
  Settings splitting = shallow();
  splitting.roulette = Roulette::efficiency;
  auto first = std::make_unique<Renderer>(scene(), splitting, kMany);
  CHECK(first->advance(4));
  Renderer copy = *first;
  first.reset();
  CHECK(copy.advance(kSamples));
  CHECK(same_bits(copy.film().moments(), rendered(scene(), kSamples, splitting, kMany)));
}

TEST("no time at all renders nothing, and asking for what is there already is done at once") {
  Renderer renderer(scene(), shallow(), kMany);
  CHECK(!renderer.advance(kSamples, 0.0));
  CHECK(renderer.counters().paths == 0);
  CHECK(renderer.advance(kSamples));
  const std::uint64_t paths = renderer.counters().paths;
  CHECK(renderer.advance(kSamples) && renderer.advance(1) && renderer.advance(0));
  CHECK(renderer.counters().paths == paths);
}

TEST("poll is asked on the calling thread, may stop the pass, and the image goes on where it was") {
  Renderer renderer(scene(), shallow(), kMany);
  const std::thread::id caller = std::this_thread::get_id();
  int calls = 0;
  const auto poll = [&] {
    CHECK(std::this_thread::get_id() == caller);
    return ++calls >= 5;  // false four times
  };
  // Until the calls have come, more samples are asked for: a short pass is over before anyone is asked.
  std::uint64_t samples = kSamples;
  while (calls < 5)
    if (renderer.advance(samples, {}, poll)) samples *= 2;
  while (!renderer.advance(samples, {}, poll)) continue;
  CHECK(same_bits(renderer.film().moments(), rendered(scene(), samples, shallow(), {.seed = 3, .threads = 2})));
}

TEST("a stop that another thread requests ends the call between blocks, and the next call goes on from there") {
  constexpr std::uint64_t kEndless = std::uint64_t{1} << 40;
  Renderer renderer(scene(), shallow(), kMany);
  std::stop_source source;
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
    source.request_stop();
  });
  CHECK(!renderer.advance(kEndless, source.get_token()));
  other.join();
  CHECK(ends_between_blocks(renderer));
  const Moments stopped = renderer.film().moments();
  CHECK(!renderer.advance(kEndless, source.get_token()));
  CHECK(same_bits(renderer.film().moments(), stopped));
  const std::uint64_t samples = std::max(renderer.position().target, kSamples);
  CHECK(renderer.advance(samples, std::stop_source().get_token()));
  CHECK(same_bits(renderer.film().moments(), rendered(scene(), samples, shallow(), {.seed = 3, .threads = 2})));
}

TEST("a call with a token ends after its seconds too") {
  Renderer renderer(scene(), shallow(), kMany);
  CHECK(!renderer.advance(std::uint64_t{1} << 40, std::stop_source().get_token(), 1e-2));
  CHECK(ends_between_blocks(renderer));
}

TEST("what poll throws reaches the caller, and the renderer can be used on") {
  Renderer renderer(scene(), shallow(), kMany);
  std::uint64_t samples = kSamples;
  bool thrown = false;
  const auto poll = []() -> bool { throw std::runtime_error("stop here"); };
  while (!thrown) {
    try {
      if (renderer.advance(samples, {}, poll)) samples *= 2;
    } catch (const std::runtime_error&) {
      thrown = true;
    }
  }
  CHECK(ends_between_blocks(renderer));
  CHECK(renderer.advance(samples));
  CHECK(same_bits(renderer.film().moments(), rendered(scene(), samples, shallow(), {.seed = 3, .threads = 2})));
}

TEST("what poll throws is never lost, not even where it is asked between two passes") {
  // A large and a small block for two threads: the one that asks waits in half of the passes for the other.
  Renderer renderer(scene(), shallow(), {.seed = 3, .threads = 2, .tile = 26});
  int asked = 0, caught = 0;
  const auto poll = [&]() -> bool { throw std::runtime_error("stop " + std::to_string(++asked)); };
  while (asked < 24) {
    try {
      renderer.advance(std::uint64_t{1} << 40, {}, poll);  // more than it can do before it asks
    } catch (const std::runtime_error&) {
      ++caught;
    }
  }
  CHECK(asked == caught);
}

TEST("renderers at work at the same time on one scene do not disturb each other") {
  std::atomic<int> same{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      if (same_bits(rendered(scene(), kSamples, shallow(), kMany), reference())) ++same;
    });
  for (std::thread& t : threads) t.join();
  CHECK(same == 3);
}

TEST("scenes are built at the same time, each for itself") {
  std::vector<std::thread> threads;
  std::atomic<int> same{0};
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      if (same_bits(rendered(built(full_room()), kSamples, shallow(), kMany), reference())) ++same;
    });
  for (std::thread& t : threads) t.join();
  CHECK(same == 3);
}

TEST("renderers that ask for the light tree at the same time share the one that is made") {
  Settings by_tree = shallow();
  by_tree.light_selection = LightSelection::tree;
  const Moments image = rendered(scene(), kSamples, by_tree, {.seed = 3, .threads = 1, .tile = 64});
  CHECK(!same_bits(image, reference()));
  const auto shared = built(full_room());
  const std::size_t without = shared->memory_bytes();
  std::vector<std::thread> threads;
  std::atomic<int> same{0};
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      if (same_bits(rendered(shared, kSamples, by_tree, kMany), image)) ++same;
    });
  for (std::thread& t : threads) t.join();
  CHECK(same == 3);
  const std::size_t with = shared->memory_bytes();
  (void)rendered(shared, 1, by_tree, kMany);
  CHECK(with > without && shared->memory_bytes() == with);
}

TEST("samples that are not numbers are counted and logged, and do not enter the film") {
  Scene bad_wall = build_scene(room());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  bad_wall.appearance.materials[1].bsdf = Diffuse<float>(DiffuseDescription{{nan, 0.5, 0.5}});
  Renderer renderer(std::make_shared<const Scene>(std::move(bad_wall)), shallow(), kMany);
  CHECK(renderer.advance(kSamples));
  const std::uint64_t bad = renderer.counters().nonfinite;
  CHECK(bad > 0 && renderer.nonfinite().size() > 0 && renderer.nonfinite().size() <= bad);
  std::uint64_t counted = 0;
  for (const PixelMoments& m : renderer.film().moments()) {
    counted += m.count;
    CHECK(std::isfinite(m.mean[0]) && std::isfinite(m.squares(0)));
  }
  CHECK(counted + bad == kSamples * renderer.film().width() * renderer.film().height());
}

}  // namespace

int main() { return check::run(); }
