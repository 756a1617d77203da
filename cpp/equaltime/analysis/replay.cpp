#include "equaltime/analysis/replay.h"

#include "equaltime/base/effects.h"
#include "equaltime/base/floating_point.h"
#include "equaltime/render/splitting.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

/// Barycentric coordinates on a triangle; elsewhere uv, known only where a texture looks at them.
std::optional<Point2f> place_on(const Scene& scene, const Interaction& it, float time) noexcept {
  const Surface& surface = scene.surfaces[it.shape];
  if (surface.mesh == kNone) return surface.textured ? std::optional(it.place) : std::nullopt;
  RayD at(Vec3d(it.anchor.p), Vec3d(it.anchor.n), 1);
  if (it.instance != kNone) at = scene.instance_at(it.instance, time).to_local(at);
  const auto [a, b, c] = scene.corners(surface.mesh, it.primitive, time);
  const auto [u, v] = barycentric(a, b, c, at.origin);
  return Point2f{u, v};
}

/// Keeps what it sees. Embree is asked nothing that the render does not ask, but for what blocks a light.
class PathTracer {
 public:
  static constexpr bool listens = true;
  static constexpr bool allocates = true;

  PathTracer(const Scene& scene, const Settings& settings, Replay& replay)
      : scene_(scene), settings_(settings), replay_(replay) {}

  template <Effects E>
  [[nodiscard]] MeetingOf<E> intersect(const Scene& scene, const Ray& ray) {
    const auto meeting = scene.intersect<E, HeldExceptions>(ray, time);
    const HeldExceptions held;
    TracedVertex& vertex = current();
    if (const auto& it = surface(meeting)) {
      vertex.it = *it;
      vertex.place = place_on(scene, *it, time);
    } else if (scene.lights.environment()) {
      const LightValue value =
          scene.lights.environment_towards(settings_.lights, settings_.environment, vertex.made.from, ray.direction);
      meets(scene.lights.last(), value.radiance, value.pdf);
    }
    return meeting;
  }
  template <Effects E>
  [[nodiscard]] bool occluded(const Scene& scene, const Ray& ray) {
    const HeldExceptions held;
    const bool blocked = scene.occluded<E>(ray, time);
    if (blocked) block(ray);
    return blocked;
  }
  template <Effects E>
  [[nodiscard]] MeetingOf<E> blocker(const Scene& scene, const Ray& ray) {
    const auto meeting = scene.intersect<E, HeldExceptions>(ray, time);
    if (const auto& it = surface(meeting)) current().light->blocker = *it;
    return meeting;
  }

  void begin(float weight) noexcept { replay_.filter_weight = weight; }
  static void scatters(const Bsdf&) noexcept {}
  static void aims(const LightSample&) noexcept {}
  const Spectrum& met(const Spectrum& L, std::uint32_t, int) noexcept {
    if (current().emitter) current().emitter->gathered = L;
    return L;
  }
  const Spectrum& lit(const Spectrum& L, int) noexcept {
    if (current().light) current().light->gathered = L;
    return L;
  }

  void note(const event::Sends& sends) {
    const int faults = take_faults();
    if (!replay_.vertices.empty()) current().faults = faults;
    replay_.vertices.push_back({sends.ray, sends.made, sends.beta, sends.L, {}, {}, {}, {}, {}});
    if (replay_.vertices.size() == 1) early_faults_ = faults;
    const std::size_t own = replay_.vertices.size() - 1;
    if (own == 0) return;
    current().from = resumes_ ? forked_ : own - 1;
    current().length = replay_.vertices[*current().from].length + 1;
    resumes_ = false;
  }
  void note(const event::Forks&) noexcept { forked_ = replay_.vertices.size() - 1; }
  void note(const event::Resumes&) noexcept { resumes_ = true; }
  void note(const event::Flies& flies) {
    TracedVertex& vertex = current();
    vertex.left = flies.beta;
    if (!flies.scattered) return;
    vertex.it = *flies.it, vertex.in_medium = true;
    vertex.place.reset(), vertex.emitter.reset();
  }
  void note(const event::MeetsEmitter& met) {
    const HeldExceptions held;
    meets(met.light, scene_.radiance<kAllEffects>(*current().it), met.light_pdf);
  }
  void note(const event::PicksLight& picks) {
    if (picks.pick) current().light = TracedLight{*picks.pick, {}, {}, 0, 0, {}, {}};
  }
  void note(const event::SamplesLight& samples) {
    current().light->sample = samples.light;
    current().light->bsdf = samples.bsdf;
    const HeldExceptions held;
    current().light->radiance = scene_.radiance_of(samples.light, time);
  }
  void note(const event::Receives& receives) {
    current().light->weight = receives.weight;
    current().light->share = receives.share;
  }
  void note(const event::Scatters& scatters) {
    const HeldExceptions held;
    TracedScattering& scattering = current().scattering.emplace();
    scattering = {
        Bsdfs::names[scatters.bsdf.index()], scatters.it, albedo<kAllEffects>(scatters.it, scatters.bsdf), {}, {}};
    if (scatters.scattered) scattering.scattered = *scatters.scattered;
  }
  void note(const event::Survives& survives) { current().scattering->survival = survives.probability; }
  static bool gives_up() noexcept { return false; }
  /// The path is at its end.
  void finish() {
    current().faults = take_faults();
    replay_.vertices.front().faults |= early_faults_;
  }

  float time = 0;  // as RayCounter's

 private:
  TracedVertex& current() noexcept { return replay_.vertices.back(); }
  void meets(std::uint32_t light, const Spectrum& radiance, float light_pdf) {
    TracedVertex& vertex = current();
    const float weight = emitter_weight(settings_, vertex.made, light, light_pdf);
    vertex.emitter = TracedEmitter{light, radiance, light_pdf, weight, {}};
  }
  void block(const Ray& ray) {
    const auto meeting = scene_.intersect<kAllEffects>(ray, time);
    if (const auto& it = surface(meeting)) current().light->blocker = *it;
  }

  const Scene& scene_;
  const Settings& settings_;
  Replay& replay_;
  int early_faults_ = 0;    // before the first ray
  std::size_t forked_ = 0;  // the vertex where the path forked
  bool resumes_ = false;    // from there, with its next ray
};

PathEnd end_of(const std::vector<TracedVertex>& vertices, int max_depth) noexcept {
  const TracedVertex& last = vertices.back();
  if (!last.it) return PathEnd::escapes;
  if (!last.scattering) return static_cast<std::size_t>(max_depth) <= last.length ? PathEnd::depth : PathEnd::absorbed;
  if (!last.scattering->scattered) return PathEnd::no_direction;
  if (!(last.left * last.scattering->scattered->weight).is_finite()) return PathEnd::not_finite;
  return last.scattering->survival ? PathEnd::roulette : PathEnd::black;
}

}  // namespace

Replay replay(const Scene& scene, const Settings& settings, std::uint64_t seed, std::uint32_t x, std::uint32_t y,
              std::uint64_t index, std::uint32_t nets) {
  scene.lights.prepare(settings.lights, settings.environment);
  Replay result{};
  PathTracer tracer(scene, settings, result);
  const RouletteDecision decision = decide_roulette(scene, settings, 1);
  const Settings learnt = decision.applied(settings);
  const BlockTask task{scene, learnt, seed, {x, y, x + 1, y + 1}, index, index + 1, nets};
  const HeldExceptions held;
  result.radiance = sample_pixel<kAllEffects>(task, x, y, index, tracer);
  tracer.finish();
  result.end = end_of(result.vertices, settings.max_depth);
  return result;
}

std::uint32_t shape_of_light(const Scene& scene, std::uint32_t light) noexcept {
  std::uint32_t owner = kNone, begin = 0;
  if (light >= scene.lights.first_delta()) return owner;
  for (std::uint32_t shape = 0; shape < scene.surfaces.size(); ++shape) {
    const std::uint32_t first = scene.surfaces[shape].first_light;
    if (first != kNone && first <= light && first >= begin) owner = shape, begin = first;
  }
  return owner != kNone && scene.surfaces[owner].shown_as != kNone ? scene.surfaces[owner].shown_as : owner;
}

}  // namespace equaltime
