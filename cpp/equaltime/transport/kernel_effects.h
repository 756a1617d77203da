// The table of kernels: one set of effects per kernel, cheapest first. CMake compiles each in a translation unit of its
// own, so that inlining in one kernel does not depend on the others.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <iterator>

#include "equaltime/base/effects.h"
#include "equaltime/transport/kernel.h"

namespace equaltime {

namespace detail {
using Fields = std::initializer_list<bool Effects::*>;

constexpr Effects with(Effects e, Fields fields) noexcept {
  for (const auto field : fields) e.*field = true;
  return e;
}
constexpr Effects without(Effects e, Fields fields) noexcept {
  for (const auto field : fields) e.*field = false;
  return e;
}
constexpr Effects with_splitting(Effects e) noexcept { return with(e, {&Effects::splitting}); }

/// All effects of scenes. Only a strategy needs splitting.
inline constexpr Effects kAllButSplitting = without(kAllEffects, {&Effects::splitting});
inline constexpr Effects kAllButMedia = without(kAllButSplitting, {&Effects::media, &Effects::phase_blends});
inline constexpr Effects kAllButMediaAndMotion = without(kAllButMedia, {&Effects::motion});
/// Effects that many scenes have.
inline constexpr Effects kCommonEffects =
    without(kAllButMediaAndMotion, {&Effects::anisotropy, &Effects::normal_maps, &Effects::masks, &Effects::lens,
                                    &Effects::instances, &Effects::hidden_emitters});
}  // namespace detail

inline constexpr std::size_t kKernelCount = 14;
inline constexpr Effects kKernelEffects[] = {
    Effects{},
    Effects{.smooth_normals = true, .environment = true},
    Effects{.analytic_shapes = true, .rough_conductors = true},
    Effects{.smooth_normals = true, .rough_conductors = true, .specular = true},
    detail::kCommonEffects,
    detail::kAllButMediaAndMotion,
    detail::with(detail::kCommonEffects, {&Effects::masks, &Effects::media}),
    Effects{.smooth_normals = true, .environment = true, .motion = true},
    detail::with(detail::kCommonEffects, {&Effects::motion}),
    detail::kAllButMedia,
    detail::kAllButSplitting,
    detail::with_splitting(Effects{}),
    detail::with_splitting(detail::kCommonEffects),
    kAllEffects,
};
static_assert(std::size(kKernelEffects) == kKernelCount, "CMake reads this number");
static_assert(kKernelEffects[kKernelCount - 1] == kAllEffects, "the last covers everything");

/// The kernel for a row of the table; compile_kernel.h defines it.
template <std::size_t Row>
[[nodiscard]] Kernel make_kernel();

}  // namespace equaltime
