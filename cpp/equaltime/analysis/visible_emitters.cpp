#include "equaltime/analysis/visible_emitters.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "equaltime/base/effects.h"

namespace equaltime {

namespace {

/// In pixels: what reaches further spreads an emitter so thin that it is no small one.
constexpr double kWidestFilter = 16;

/// A point of an emitter, connected to the camera.
struct CameraConnection {
  FilmPoint place;
  Spectrum radiance;
  float pdf;  // of the direction
};

/// The camera from one point of its lens, or its only one.
struct LensSample {
  const Scene& scene;
  Point2f lens;

  [[nodiscard]] static bool possible(const Scene& scene) noexcept {
    return !scene.camera.motion && scene.camera.filter.radius() <= kWidestFilter &&
           (std::holds_alternative<PerspectiveCamera>(scene.camera.sensor) ||
            std::holds_alternative<ThinLensCamera>(scene.camera.sensor));
  }
  [[nodiscard]] Vec3d origin() const noexcept {
    if (const auto* thin = std::get_if<ThinLensCamera>(&scene.camera.sensor)) return thin->origin(lens);
    return std::get_if<PerspectiveCamera>(&scene.camera.sensor)->origin();
  }
  [[nodiscard]] std::optional<FilmPoint> place(const Vec3d& direction) const noexcept {
    if (const auto* thin = std::get_if<ThinLensCamera>(&scene.camera.sensor)) return thin->place(direction, lens);
    return std::get_if<PerspectiveCamera>(&scene.camera.sensor)->place(direction);
  }
};

/// Rectangle of pixels in which emitters are looked for: the crop, or the whole film.
struct Window {
  std::uint32_t x, y, width, height;

  Window(const FilmDescription& film, bool whole) noexcept
      : x(whole ? 0 : film.crop_x),
        y(whole ? 0 : film.crop_y),
        width(whole ? film.width : film.crop_width),
        height(whole ? film.height : film.crop_height) {}
};

/// Whether the filter of a pixel of the window reaches the place.
bool is_near(const Window& window, const Scene& scene, const FilmPoint& place) noexcept {
  const auto within = [&](double at, std::uint32_t from, std::uint32_t size) {
    return std::abs(at - from - 0.5 * size) < 0.5 * size + scene.camera.filter.radius();
  };
  return within(place.x, window.x, window.width) && within(place.y, window.y, window.height);
}

/// Radiance of the light sample along the camera ray through a film position; black if it is occluded.
Spectrum seen(const Scene& scene, const FilmPoint& place, Point2f lens, const LightSample<float>& light,
              float time) noexcept {
  const Ray ray = camera_ray<kAllEffects>(
      scene.camera.sensor, scene.camera.motion, place.x, place.y, [&]() noexcept { return lens; }, time);
  const Optional<Interaction> it = scene.geometry.closest<kAllEffects>(ray, time).it;
  if (light.infinite) return it ? Spectrum() : light.radiance;
  if (!it || !it->front || !scene.geometry.emits(*it) || scene.geometry.light_of(*it) != light.light) return {};
  return scene.radiance<kAllEffects>(*it);
}

std::optional<CameraConnection> look(const Scene& scene, const Window& window, const Settings& settings,
                                     const Sampler& sampler) noexcept {
  const LensSample outlook{scene, sampler.get_2d(slot(CameraDecision::lens))};
  const float time = sampler.get_1d(slot(CameraDecision::time));
  const LightSampleContext receiver{Vec3f(outlook.origin()), {}, false};
  const Point2f u = sampler.get_2d(slot(BounceDecision::light_point, 0));
  const auto light = scene.lights.sample<kAllEffects>(settings.light_selection, settings.environment_sampling,
                                                      {receiver, sampler, 0, u, time});
  if (!light || light->delta || !(light->pdf > 0)) return std::nullopt;
  const auto place = outlook.place(Vec3d(light->wi));
  if (!place || !is_near(window, scene, *place)) return std::nullopt;
  return CameraConnection{*place, seen(scene, *place, outlook.lens, *light, time), light->pdf};
}

/// Adds a connected point to the pixels whose filters reach it. `per_point`: one over the number of points.
void add(const Scene& scene, const Window& window, const CameraConnection& sight, double per_point,
         std::map<std::uint32_t, EmittersOfPixel>& found) {
  const double scale = scene.normalization.world_radiance_scale(), radius = scene.camera.filter.radius();
  const auto& [x, y, solid_angle] = sight.place;
  const auto first = [&](double at, std::uint32_t from) {
    return static_cast<std::int64_t>(std::max(std::ceil(at - radius - 0.5) - from, 0.0));
  };
  const auto last = [&](double at, std::uint32_t from, std::uint32_t size) {
    return static_cast<std::int64_t>(std::min(std::floor(at + radius - 0.5) - from, size - 1.0));
  };
  for (std::int64_t row = first(y, window.y); row <= last(y, window.y, window.height); ++row)
    for (std::int64_t column = first(x, window.x); column <= last(x, window.x, window.width); ++column) {
      const auto [density, weight] = scene.camera.filter.drawn(x - (static_cast<double>(column) + window.x + 0.5),
                                                               y - (static_cast<double>(row) + window.y + 0.5));
      if (!(density > 0)) continue;
      const double times = per_point * density / (solid_angle * static_cast<double>(sight.pdf));
      found[static_cast<std::uint32_t>(row * window.width + column)].add(sight.radiance, scale * weight, times);
    }
}

}  // namespace

std::map<std::uint32_t, EmittersOfPixel> find_visible_emitters(const Scene& scene, Settings settings,
                                                               std::uint64_t seed, std::uint64_t points,
                                                               bool whole_film) {
  const bool none = scene.lights.first_delta() == 0 && !scene.lights.environment();
  if (none || scene.rules.hides_emitters || settings.max_depth < 1 || !LensSample::possible(scene)) return {};
  settings.light_selection = LightSelection::power;
  scene.lights.prepare(settings.light_selection, settings.environment_sampling);
  const Window window(scene.camera.film, whole_film);
  std::map<std::uint32_t, EmittersOfPixel> found;
  for (std::uint64_t i = 0; i < points; ++i) {
    const auto sight = look(scene, window, settings, Sampler::at(SamplerKind::sobol, seed, 0, i, 1));
    if (sight && !sight->radiance.is_black()) add(scene, window, *sight, 1 / static_cast<double>(points), found);
  }
  return found;
}

}  // namespace equaltime
