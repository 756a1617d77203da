// The sets of effects for which kernels are compiled, cheapest first. CMake makes a translation unit of each, so that
// the compiler inlines into one as it would if there were no others.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <iterator>

#include "equaltime/base/effects.h"
#include "equaltime/transport/kernels.h"

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

/// What no scene calls for, but a strategy, left out.
inline constexpr Effects kAllButSplitting = without(kAllEffects, {&Effects::splitting});
inline constexpr Effects kAllButMedia = without(kAllButSplitting, {&Effects::media, &Effects::phase_blends});
inline constexpr Effects kAllButMediaAndMotion = without(kAllButMedia, {&Effects::motion});
/// All but what few scenes call for.
inline constexpr Effects kCommonEffects =
    without(kAllButMediaAndMotion, {&Effects::anisotropy, &Effects::normal_maps, &Effects::masks, &Effects::lens,
                                    &Effects::instances, &Effects::hidden_emitters});
}  // namespace detail

inline constexpr std::size_t kKernelRows = 14;
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
static_assert(std::size(kKernelEffects) == kKernelRows, "CMake reads how many rows there are");
static_assert(kKernelEffects[kKernelRows - 1] == kAllEffects, "the last covers everything");

/// The kernel for the effects of a row; each is compiled by itself (kernel_row.h).
template <std::size_t Row>
[[nodiscard]] KernelRow kernel_row();

}  // namespace equaltime
