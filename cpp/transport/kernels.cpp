#include "transport/kernels.h"

#include "transport/sample_pixel.h"

namespace equaltime {

namespace {

template <Effects E>
void render_block(const BlockTask& task, Film& film, RayCounter& probe, std::vector<NonFinite>& nonfinite) {
  render_samples(task, film, probe, nonfinite, [&](std::uint32_t x, std::uint32_t y, std::uint64_t i) {
    return sample_pixel<E>(task, x, y, i, film.replicates(), probe);
  });
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
  e.anisotropy = e.normal_maps = e.masks = e.lens = e.instances = e.media = e.forks = e.motion = false;
  return e;
}();

constexpr Effects kAllButForks = [] {
  Effects e = kAllEffects;
  e.forks = false;
  return e;
}();

/// What scenes with media call for, the most of them: their boundaries are nothing.
constexpr Effects kCommonWithMedia = [] {
  Effects e = kCommonEffects;
  e.media = e.masks = true;
  return e;
}();

constexpr Effects kCommonInMotion = [] {
  Effects e = kCommonEffects;
  e.motion = true;
  return e;
}();

constexpr Effects kAllButMediaAndMotion = [] {
  Effects e = kAllButForks;
  e.media = e.motion = false;
  return e;
}();

constexpr Effects forking(Effects e) noexcept {
  e.forks = true;
  return e;
}

const std::vector<KernelRow>& kernel_rows() noexcept {
  static const std::vector<KernelRow> rows = {
      row<Effects{}>(),
      row<Effects{.environment = true}>(),
      row<Effects{.smooth_normals = true, .environment = true}>(),
      row<Effects{.analytic_shapes = true}>(),
      row<Effects{.analytic_shapes = true, .rough_conductors = true}>(),
      row<Effects{.smooth_normals = true, .rough_conductors = true, .specular = true}>(),
      row<kCommonEffects>(),
      row<kAllButMediaAndMotion>(),
      row<kCommonWithMedia>(),
      row<Effects{.smooth_normals = true, .environment = true, .motion = true}>(),
      row<kCommonInMotion>(),
      row<kAllButForks>(),
      row<Effects{.forks = true}>(),
      row<Effects{.analytic_shapes = true, .rough_conductors = true, .forks = true}>(),
      row<forking(kCommonEffects)>(),
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
