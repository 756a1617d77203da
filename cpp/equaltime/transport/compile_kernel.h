// Compiles one kernel. CMake makes a file per row of kernel_effects.h that includes this and instantiates make_kernel.
#pragma once

#include "equaltime/transport/kernel_effects.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace detail {

template <Effects E>
void render_block(const BlockTask& task, Film& film, RayCounter& counter, SampleLog<NonFinite>& nonfinite) {
  render_samples(task, film, counter, nonfinite, [&](std::uint32_t x, std::uint32_t y, std::uint64_t i) {
    return sample_pixel<E>(task, x, y, i, counter);
  });
}

template <Effects E>
void record_block(const BlockTask& task, RayRecorder& recorder) {
  for (std::uint32_t y = task.block.y0; y < task.block.y1; ++y)
    for (std::uint32_t x = task.block.x0; x < task.block.x1; ++x)
      for (std::uint64_t i = task.first; i < task.last; ++i) (void)sample_pixel<E>(task, x, y, i, recorder);
}

}  // namespace detail

template <std::size_t Row>
Kernel make_kernel() {
  constexpr Effects kEffects = kKernelEffects[Row];
  return {kEffects, detail::render_block<kEffects>, detail::record_block<kEffects>};
}

}  // namespace equaltime
