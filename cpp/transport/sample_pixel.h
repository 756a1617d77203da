// One sample of a pixel: what every kernel does, whoever takes its radiance.
#pragma once

#include "transport/kernels.h"
#include "transport/path.h"

namespace equaltime {

/// The camera ray of one sample, its path, and the weight of its place under the pixel filter.
template <Effects E, class Probe>
EQUALTIME_INLINE Spectrum sample_pixel(const BlockTask& task, std::uint32_t x, std::uint32_t y, std::uint64_t index,
                                       std::uint32_t replicates, Probe& probe) {
  const Scene& scene = task.scene;
  const std::uint64_t px = x + scene.film.crop_x, py = y + scene.film.crop_y;
  const std::uint64_t pixel = py * scene.film.width + px;
  const Sampler sampler = Sampler::at(task.settings.sampler, task.seed, pixel, index, replicates);
  const PixelFilter::Offset offset = scene.filter.sample(sampler.get_2d(slot(CameraDimension::pixel)));
  probe.begin(offset.weight);
  const Ray ray =
      camera_ray<E>(scene.sensor, static_cast<double>(px) + 0.5 + offset.x, static_cast<double>(py) + 0.5 + offset.y,
                    [&]() noexcept { return sampler.get_2d(slot(CameraDimension::lens)); });
  return trace_path<E>(scene, task.settings, ray, sampler, probe) * offset.weight;
}

}  // namespace equaltime
