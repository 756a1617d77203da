#include "transport/kernels.h"

#include "transport/sample_pixel.h"

namespace equaltime {

namespace {

template <Effects E>
void render_block(const BlockTask& task, Film& film, RayCounter& probe, std::vector<NonFinite>& nonfinite) {
  const double scale = task.scene.normalization.world_radiance_scale();
  const std::uint32_t replicates = film.replicates();
  for (std::uint32_t y = task.block.y0; y < task.block.y1; ++y)
    for (std::uint32_t x = task.block.x0; x < task.block.x1; ++x) {
      const std::size_t pixel = std::size_t{y} * film.width() + x;
      const std::uint64_t first = task.schedule ? task.schedule->count(pixel, task.first) : task.first;
      const std::uint64_t last = task.schedule ? task.schedule->count(pixel, task.last) : task.last;
      const std::uint64_t rays = probe.counters.rays + probe.counters.shadow_rays;
      for (std::uint64_t i = first; i < last; ++i) {
        const Spectrum L = sample_pixel<E>(task, x, y, i, replicates, probe);
        if (L.is_finite()) {
          film.at(static_cast<std::uint32_t>(i % replicates), x, y).add(L, scale);
        } else {
          ++probe.counters.nonfinite;
          nonfinite.push_back({x, y, i});
        }
      }
      if (task.pixel_rays) task.pixel_rays[pixel] += probe.counters.rays + probe.counters.shadow_rays - rays;
    }
}

template <Effects E>
void record_block(const BlockTask& task, std::uint32_t replicates, RayRecorder& probe) {
  for (std::uint32_t y = task.block.y0; y < task.block.y1; ++y)
    for (std::uint32_t x = task.block.x0; x < task.block.x1; ++x)
      for (std::uint64_t i = task.first; i < task.last; ++i) (void)sample_pixel<E>(task, x, y, i, replicates, probe);
}

template <Effects E>
KernelRow row() {
  return {E, render_block<E>, record_block<E>};
}

}  // namespace

/// All but what few scenes call for.
constexpr Effects kCommonEffects = [] {
  Effects e = kAllEffects;
  e.anisotropy = e.normal_maps = e.masks = e.lens = e.instances = e.media = false;
  return e;
}();

/// What scenes with media call for, the most of them: their boundaries are nothing.
constexpr Effects kCommonWithMedia = [] {
  Effects e = kCommonEffects;
  e.media = e.masks = true;
  return e;
}();

constexpr Effects kAllButMedia = [] {
  Effects e = kAllEffects;
  e.media = false;
  return e;
}();

const std::vector<KernelRow>& kernel_rows() noexcept {
  static const std::vector<KernelRow> rows = {
      row<Effects{}>(),
      row<Effects{.environment = true}>(),
      row<Effects{.smooth_normals = true, .environment = true}>(),
      row<Effects{.analytic_shapes = true}>(),
      row<Effects{.analytic_shapes = true, .rough_conductors = true}>(),
      row<Effects{.smooth_normals = true, .rough_conductors = true, .specular = true}>(),
      row<kCommonEffects>(),
      row<kAllButMedia>(),
      row<kCommonWithMedia>(),
      row<kAllEffects>(),
  };
  return rows;
}

const KernelRow& choose_kernel(const Effects& need) noexcept {
  for (const KernelRow& row : kernel_rows())
    if (row.effects.covers(need)) return row;
  return kernel_rows().back();
}

std::string kernel_name(const Effects& e) {
  std::string name;
  for (const auto& [used, word] : kEffectFields) {
    if (!(e.*used)) continue;
    if (!name.empty()) name += '+';
    name += word;
  }
  return name.empty() ? "diffuse meshes" : name;
}

}  // namespace equaltime
