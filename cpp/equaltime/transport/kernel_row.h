// One compiled kernel: a file that CMake makes of each row (CMakeLists.txt) includes this and instantiates kernel_row.
#pragma once

#include "equaltime/transport/kernel_rows.h"
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
KernelRow kernel_row() {
  constexpr Effects kEffects = kKernelEffects[Row];
  return {kEffects, detail::render_block<kEffects>, detail::record_block<kEffects>};
}

}  // namespace equaltime
