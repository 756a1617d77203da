#include "equaltime/transport/kernels.h"

#include <initializer_list>

#include "equaltime/base/effects.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

template <Effects E>
void render_block(const BlockTask& task, Film& film, RayCounter& probe, SampleLog<NonFinite>& nonfinite) {
  render_samples(task, film, probe, nonfinite, [&](std::uint32_t x, std::uint32_t y, std::uint64_t i) {
    return sample_pixel<E>(task, x, y, i, probe);
  });
}

template <Effects E>
void record_block(const BlockTask& task, RayRecorder& probe) {
  for (std::uint32_t y = task.block.y0; y < task.block.y1; ++y)
    for (std::uint32_t x = task.block.x0; x < task.block.x1; ++x)
      for (std::uint64_t i = task.first; i < task.last; ++i) (void)sample_pixel<E>(task, x, y, i, probe);
}

template <Effects E>
KernelRow row() {
  return {E, render_block<E>, record_block<E>};
}

using Fields = std::initializer_list<bool Effects::*>;

constexpr Effects with(Effects e, Fields fields) noexcept {
  for (const auto field : fields) e.*field = true;
  return e;
}

constexpr Effects without(Effects e, Fields fields) noexcept {
  for (const auto field : fields) e.*field = false;
  return e;
}

constexpr Effects forking(Effects e) noexcept { return with(e, {&Effects::forks}); }

/// What no scene calls for, but a strategy, left out.
constexpr Effects kAllButForks = without(kAllEffects, {&Effects::forks});
constexpr Effects kAllButMedia = without(kAllButForks, {&Effects::media, &Effects::phase_blends});
constexpr Effects kAllButMediaAndMotion = without(kAllButMedia, {&Effects::motion});
/// All but what few scenes call for.
constexpr Effects kCommonEffects =
    without(kAllButMediaAndMotion, {&Effects::anisotropy, &Effects::normal_maps, &Effects::masks, &Effects::lens,
                                    &Effects::instances, &Effects::hidden_emitters});

}  // namespace

const std::vector<KernelRow>& kernel_rows() noexcept {
  // Sanitizers take half a minute to compile each; those that are left out have no code of their own.
#ifdef EQUALTIME_FEW_KERNELS
  static const std::vector<KernelRow> rows = {
      row<Effects{}>(),
      row<kCommonEffects>(),
      row<with(kCommonEffects, {&Effects::masks, &Effects::media})>(),
      row<kAllButForks>(),
      row<forking(kCommonEffects)>(),
      row<kAllEffects>(),
  };
#else
  static const std::vector<KernelRow> rows = {
      row<Effects{}>(),
      row<Effects{.smooth_normals = true, .environment = true}>(),
      row<Effects{.analytic_shapes = true, .rough_conductors = true}>(),
      row<Effects{.smooth_normals = true, .rough_conductors = true, .specular = true}>(),
      row<kCommonEffects>(),
      row<kAllButMediaAndMotion>(),
      row<with(kCommonEffects, {&Effects::masks, &Effects::media})>(),
      row<Effects{.smooth_normals = true, .environment = true, .motion = true}>(),
      row<with(kCommonEffects, {&Effects::motion})>(),
      row<kAllButMedia>(),
      row<kAllButForks>(),
      row<forking(Effects{})>(),
      row<forking(kCommonEffects)>(),
      row<kAllEffects>(),
  };
#endif
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
