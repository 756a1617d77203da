// Failures during a render: an allocation fails, or a material returns NaN.
#include <atomic>
#include <cstdlib>
#include <limits>
#include <new>

#include "equaltime/analysis/limit.h"
#include "equaltime/analysis/replay.h"
#include "tests/check.h"
#include "tests/scenes.h"

namespace {

/// Allocations of at least `least` bytes that still succeed; none fails while it is negative.
std::atomic<long> left{-1};
std::atomic<std::size_t> least{0};

void* allocate(std::size_t size) {
  if (size >= least && left >= 0 && left.fetch_sub(1) == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size); }
void* operator new[](std::size_t size) { return allocate(size); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size > 0 ? size : 1); }
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept { return std::malloc(size > 0 ? size : 1); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace {

using namespace scenes;

constexpr std::uint64_t kSamples = 18;
constexpr RenderOptions kMany{.seed = 3, .threads = 3, .tile = 8};

Settings settings() {
  Settings s;
  s.max_depth = 4;
  return s;
}

/// Whether `work` ends with std::bad_alloc if its allocation number `n`, of at least `bytes`, fails.
template <class Work>
bool runs_out(long n, std::size_t bytes, const Work& work) {
  least = bytes, left = n;
  try {
    work();
  } catch (const std::bad_alloc&) {
    left = -1;
    return true;
  }
  left = -1;
  return false;
}

TEST("after memory ran out in a worker, a render goes on to the same bits") {
  const auto scene = built(full_room());
  const Moments whole = rendered(scene, kSamples, settings(), {.seed = 3, .threads = 1, .tile = 64});
  constexpr std::size_t kBlock = 64 * sizeof(PixelMoments);  // what a worker keeps of a block, and nothing smaller
  for (long n = 0; n < 3; ++n) {
    Renderer renderer(scene, settings(), kMany);
    const bool failed = runs_out(n, kBlock, [&] { renderer.advance(kSamples); });
    CHECK(failed || n > 0);                    // one worker may have taken all blocks before the others began
    Renderer other(scene, settings(), kMany);  // as from a checkpoint
    other.film().moments() = renderer.film().moments();
    other.resume(renderer.counters(), renderer.position());
    for (Renderer* next : {&renderer, &other}) {
      CHECK(next->advance(kSamples));
      CHECK(same_bits(next->film().moments(), whole));
      CHECK(next->counters().paths == kSamples * next->film().width() * next->film().height());
    }
  }
}

TEST("a replay and a recording that find no memory throw") {
  const auto scene = built(full_room());
  const auto trace = [&] { (void)replay(*scene, settings(), 0, 12, 20, 0, 2); };
  trace();  // what is prepared once is there
  long allocations = 0;
  while (runs_out(allocations, 0, trace)) ++allocations;
  CHECK(allocations >= 2);

  const auto measure = [&] {
    (void)measure_limit(scene, settings(), {.threads = 1}, {.samples = 1, .pairs = 1, .memory_bytes = 1 << 20}, {});
  };
  constexpr std::size_t kRays = 16 * sizeof(RecordedRay);
  CHECK(runs_out(0, kRays, measure));
  CHECK(runs_out(20, kRays, measure));
}

/// A closed sphere that emits, and whose reflectance is NaN in one channel.
std::shared_ptr<const Scene> with_a_bad_reflectance() {
  SceneDescription d = room();
  d.bsdfs = {DiffuseDescription{{1, 1, 1}}};
  d.shapes = {SphereDescription{{0, 1, 0}, 10, true, {0, {}, Vec3d{1, 1, 1}}}};
  Scene scene = build_scene(std::move(d));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  scene.appearance.materials[0].bsdf = Diffuse<float>(DiffuseDescription{{nan, 1, 1}});
  return std::make_shared<const Scene>(std::move(scene));
}

TEST("a path whose throughput is not a number ends, and is a sample that is not finite") {
  for (const Roulette roulette : {Roulette::throughput, Roulette::albedo, Roulette::none}) {
    Settings endless;
    endless.roulette = roulette;
    Renderer renderer(with_a_bad_reflectance(), endless, {.threads = 2});
    renderer.advance(1);
    const Counters& counters = renderer.counters();
    CHECK(counters.nonfinite == counters.paths);
    CHECK(counters.rays <= 2 * counters.paths);
  }
}

TEST("a log keeps its first entries, and drops the last of them when told to") {
  SampleLog<int> log;
  for (int i = 0; i < 1000; ++i) log.add(i);
  CHECK(log.size() == 64 && *log.begin() == 0 && *(log.end() - 1) == 63);
  log.shrink(2);
  log.add(7);
  CHECK(log.size() == 3 && *(log.end() - 1) == 7);
}

TEST("a replay says that a throughput which is not a number ended the path") {
  const Replay path = replay(*with_a_bad_reflectance(), settings(), 0, 12, 20, 0, 2);
  CHECK(path.end == PathEnd::not_finite && path.vertices.size() == 1);
}

TEST("samples that are not finite are counted one by one, and logged up to a limit") {
  Renderer renderer(with_a_bad_reflectance(), settings(), {.threads = 2});
  renderer.advance(32);
  CHECK(renderer.counters().nonfinite == std::uint64_t{32} * renderer.film().width() * renderer.film().height());
  CHECK(renderer.nonfinite().size() == 64);
}

}  // namespace

int main() { return check::run(); }
