#include "equaltime/analysis/replay.h"

#include "equaltime/base/effects.h"
#include "equaltime/base/floating_point.h"
#include "equaltime/render/splitting.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

/// Barycentric coordinates on a triangle; elsewhere uv, known only where a texture looks at them.
std::optional<Point2f> prim_uv_at(const SceneGeometry& geometry, const Interaction& it, float time) noexcept {
  const Surface& surface = geometry.surfaces[it.shape];
  if (surface.mesh.number == kNone) return surface.textured ? std::optional(it.prim_uv) : std::nullopt;
  RayD at(Vec3d(it.anchor.p), Vec3d(it.anchor.n), 1);
  if (it.instance != kNone) at = geometry.instance_at(it.instance, time).to_local(at);
  const auto [a, b, c] = geometry.corners(surface.mesh.number, it.primitive, time);
  const auto [u, v] = barycentric(a, b, c, at.origin);
  return Point2f{u, v};
}

/// Keeps what it sees. Embree is asked nothing that the render does not ask, but for what blocks a light.
class ReplayObserver : public PathObserver {
 public:
  static constexpr bool allocates = true;
  using Guard = ScopedFpEnvironment;

  ReplayObserver(const Scene& scene, const Settings& settings, Replay& replay)
      : scene_(scene), settings_(settings), replay_(replay) {}

  void on(const event::PathStarted& path) noexcept { replay_.filter_weight = path.filter_weight; }
  void on(const event::RayTraced& traced) {
    time_ = traced.time;
    const int faults = take_faults();
    if (!replay_.vertices.empty()) current().faults = faults;
    replay_.vertices.push_back({traced.ray, traced.previous, traced.beta, traced.L, {}, {}, {}, {}, {}});
    if (replay_.vertices.size() == 1) early_faults_ = faults;
    const std::size_t own = replay_.vertices.size() - 1;
    if (own == 0) return;
    current().from = resumes_ ? split_at_ : own - 1;
    current().length = replay_.vertices[*current().from].length + 1;
    resumes_ = false;
  }
  void on(const event::RayHit& hit) {
    const ScopedFpEnvironment held;
    TracedVertex& vertex = current();
    if (hit.it) {
      vertex.it = *hit.it;
      vertex.prim_uv = prim_uv_at(scene_.geometry, *hit.it, time_);
    } else if (scene_.lights.environment()) {
      const LightValue<float> value = scene_.lights.environment_towards(
          settings_.light_selection, settings_.environment_sampling, vertex.previous.from, hit.ray.direction);
      meets(scene_.lights.environment_index(), value.radiance, value.pdf);
    }
  }
  void on(const event::EmissionAdded& added) noexcept {
    if (current().emitter) current().emitter->gathered = added.L;
  }
  void on(const event::ShadowRayTraced& shadow) {
    const ScopedFpEnvironment held;
    if (shadow.blocked) block(shadow.ray);
  }
  void on(const event::ShadowRayHit& shadow) {
    if (shadow.it) current().light->closest_occluder = *shadow.it;
  }
  void on(const event::DirectLightAdded& added) noexcept {
    if (current().light) current().light->gathered = added.L;
  }
  void on(const event::PathSplit&) noexcept { split_at_ = replay_.vertices.size() - 1; }
  void on(const event::CopyResumed&) noexcept { resumes_ = true; }
  void on(const event::DistanceSampled& sampled) {
    TracedVertex& vertex = current();
    vertex.left = sampled.beta;
    if (!sampled.scattered) return;
    vertex.it = *sampled.it, vertex.in_medium = true;
    vertex.prim_uv.reset(), vertex.emitter.reset();
  }
  void on(const event::EmitterHit& hit) {
    const ScopedFpEnvironment held;
    meets(hit.light, scene_.radiance<kAllEffects>(*current().it), hit.light_pdf);
  }
  void on(const event::LightPicked& picked) {
    if (picked.pick) current().light = TracedLight{*picked.pick, {}, {}, 0, 0, {}, {}};
  }
  void on(const event::LightSampled& sampled) {
    current().light->sample = sampled.light;
    current().light->bsdf = sampled.bsdf;
    const ScopedFpEnvironment held;
    current().light->radiance = scene_.radiance_of(sampled.light, time_);
  }
  void on(const event::LightReceived& received) {
    current().light->weight = received.weight;
    current().light->visibility = received.visibility;
  }
  void on(const event::DirectionSampled& at) {
    const ScopedFpEnvironment held;
    TracedScattering& scattering = current().scattering.emplace();
    scattering = {at.scatterer.name(), at.it, albedo<kAllEffects>(at.it, at.scatterer), {}, {}};
    if (at.scattered) scattering.scattered = *at.scattered;
  }
  void on(const event::RouletteBegun& survived) { current().scattering->survival = survived.probability; }
  /// The path is at its end.
  void finish() {
    current().faults = take_faults();
    replay_.vertices.front().faults |= early_faults_;
  }

 private:
  TracedVertex& current() noexcept { return replay_.vertices.back(); }
  void meets(std::uint32_t light, const Spectrum& radiance, float light_pdf) {
    TracedVertex& vertex = current();
    const float weight = emission_mis_weight(settings_, vertex.previous, light, light_pdf);
    vertex.emitter = TracedEmitter{light, radiance, light_pdf, weight, {}};
  }
  void block(const Ray& ray) {
    const auto hit = scene_.geometry.closest<kAllEffects>(ray, time_);
    if (const auto& it = hit.it) current().light->closest_occluder = *it;
  }

  const Scene& scene_;
  const Settings& settings_;
  Replay& replay_;
  float time_ = 0;            // of the path
  int early_faults_ = 0;      // before the first ray
  std::size_t split_at_ = 0;  // the vertex where the path was split
  bool resumes_ = false;      // from there, with its next ray
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
  scene.lights.prepare(settings.light_selection, settings.environment_sampling);
  Replay result{};
  ReplayObserver tracer(scene, settings, result);
  Stop never;
  const RouletteDecision decision = decide_roulette(scene, settings, 1, never);
  never.rethrow();
  const Settings decided = decision.applied(settings);
  const BlockTask task{scene, decided, seed, {x, y, x + 1, y + 1}, index, index + 1, nets};
  const ScopedFpEnvironment held;
  result.radiance = sample_pixel<kAllEffects>(task, x, y, index, tracer);
  tracer.finish();
  result.end = end_of(result.vertices, settings.max_depth);
  return result;
}

std::uint32_t shape_of_light(const Scene& scene, std::uint32_t light) noexcept {
  std::uint32_t owner = kNone, begin = 0;
  if (light >= scene.lights.first_delta()) return owner;
  for (std::uint32_t shape = 0; shape < scene.geometry.surfaces.size(); ++shape) {
    const std::uint32_t first = scene.geometry.surfaces[shape].emission.first_light;
    if (first != kNone && first <= light && first >= begin) owner = shape, begin = first;
  }
  return owner != kNone && scene.geometry.surfaces[owner].source_shape != kNone
             ? scene.geometry.surfaces[owner].source_shape
             : owner;
}

}  // namespace equaltime
