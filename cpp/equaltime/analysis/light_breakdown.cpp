#include "equaltime/analysis/light_breakdown.h"

#include <algorithm>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

constexpr const char* kWayNames[BreakdownParts::kWays] = {"seen", "met", "aimed"};

}  // namespace

BreakdownParts::BreakdownParts(const Scene& scene, std::span<const std::uint32_t> surface_groups)
    : light_part_(scene.lights.size()) {
  for (std::uint32_t i = 1; i <= kLengths; ++i) names_.push_back({"length", std::to_string(i)});
  for (const char* way : kWayNames) names_.push_back({"way", way});
  names_.push_back({"bsdf", "none"});
  for (const char* bsdf : Bsdfs::names) names_.push_back({"bsdf", bsdf});
  for (const char* phase : PhaseFunctions::names) names_.push_back({"bsdf", phase});
  name_surfaces(scene, surface_groups);
  name_lights(scene);
}

/// Surfaces of a moving group belong to the shape of the description that the group stands for.
void BreakdownParts::name_surfaces(const Scene& scene, std::span<const std::uint32_t> groups) {
  first_surface_ = count();
  for (const char* what : {"none", "medium"}) names_.push_back({"surface", what});
  const std::uint32_t last = groups.empty() ? 0 : std::ranges::max(groups);
  for (std::uint32_t group = 0; group <= last; ++group) names_.push_back({"surface", std::to_string(group)});
  if (groups.empty()) return;
  const std::vector<Surface>& surfaces = scene.geometry.surfaces;
  for (std::uint32_t i = 0; i < surfaces.size(); ++i)
    surface_groups_.push_back(groups[surfaces[i].source_shape != kNone ? surfaces[i].source_shape : i]);
}

/// A shape is one light here, of however many triangles.
void BreakdownParts::name_lights(const Scene& scene) {
  const std::uint32_t first = count();
  std::vector<std::string> starts(light_part_.size());
  for (std::size_t i = 0; i < scene.geometry.surfaces.size(); ++i)
    if (const std::uint32_t light = scene.geometry.surfaces[i].emission.first_light; light != kNone)
      starts[light] = "shape " + std::to_string(i);
  for (std::uint32_t i = scene.lights.first_delta(); i < starts.size(); ++i)
    starts[i] = "light " + std::to_string(i - scene.lights.first_delta());
  const bool has_environment = scene.lights.environment().has_value();
  bool others = false;
  for (std::size_t i = 0; i < starts.size() - has_environment; ++i) {
    const bool room = count() < first + kMostLights;
    if (!starts[i].empty() && room) names_.push_back({"light", starts[i]});
    others = others || (!starts[i].empty() && !room);
    light_part_[i] = count() - 1;
  }
  if (others) names_.back().what = "others";
  if (has_environment) {
    names_.push_back({"light", "environment"});
    light_part_.back() = count() - 1;
  }
}

void BreakdownObserver::add(const Spectrum& L, int depth, std::uint32_t way, std::uint32_t light) {
  added_.push_back({L,
                    {BreakdownParts::length(depth), BreakdownParts::way(way), BreakdownParts::bsdf(bsdf_), surface_,
                     parts_.light(light)}});
}

void BreakdownObserver::add_to(std::span<double> pixel) const noexcept {
  for (const auto& [L, parts] : added_)
    for (const std::uint32_t part : parts) {
      double* sum = &pixel[3 * std::size_t{part}];
      sum[0] += static_cast<double>(L.r) * weight_;
      sum[1] += static_cast<double>(L.g) * weight_;
      sum[2] += static_cast<double>(L.b) * weight_;
    }
}

LightBreakdown break_down_light(std::shared_ptr<const Scene> scene, const Settings& settings,
                                const RenderOptions& options, std::uint64_t samples, bool only_lengths,
                                std::span<const std::uint32_t> surface_groups, const Poll& poll) {
  Renderer renderer(scene, settings, options);
  const Settings& decided = renderer.decide();
  LightBreakdown found{BreakdownParts(*scene, surface_groups),
                       scene->camera.film.crop_height,
                       scene->camera.film.crop_width,
                       BreakdownParts::kLengths,
                       {}};
  if (!only_lengths) found.kept = found.parts.count();
  const std::size_t row = 3 * std::size_t{found.kept};
  found.means.resize(row * found.height * found.width);
  const double scale = scene->normalization.world_radiance_scale();
  const std::vector<PixelBlock> blocks = renderer.blocks();
  const auto make_worker = [&] {
    // The sums are of one pixel: what is kept of it is rounded once.
    return [&, observer = BreakdownObserver(found.parts, scene->rules.count_null_interfaces),
            sums = std::vector<double>(3 * std::size_t{found.parts.count()})](std::size_t i) mutable {
      const PixelBlock& block = blocks[i];
      const BlockTask task{*scene, decided, options.seed, block, 0, samples, options.nets};
      for (std::uint32_t y = block.y0; y < block.y1; ++y)
        for (std::uint32_t x = block.x0; x < block.x1; ++x) {
          std::ranges::fill(sums, 0.0);
          double count = 0;
          for (std::uint64_t s = 0; s < samples; ++s)
            if (sample_pixel<kAllEffects>(task, x, y, s, observer).is_finite()) observer.add_to(sums), ++count;
          const double per_sample = count > 0 ? scale / count : 0.0;
          std::ranges::transform(std::span(sums).first(row), &found.means[row * (std::size_t{y} * found.width + x)],
                                 [=](double sum) { return static_cast<float>(sum * per_sample); });
        }
    };
  };
  run_blocks(blocks.size(), renderer.threads(), make_worker, poll);
  return found;
}

}  // namespace equaltime
