// Samples of a pixel: camera ray, path, and weight of the pixel filter.
#pragma once

#include <limits>

#include "equaltime/base/effects.h"
#include "equaltime/transport/kernel.h"
#include "equaltime/transport/path.h"

namespace equaltime {

/// The numbers of one sample of a pixel of the full film, and its place under the filter.
struct FilmSample {
  Sampler sampler;
  PixelFilter::Offset offset;

  EQUALTIME_INLINE FilmSample(const BlockTask& task, std::uint64_t px, std::uint64_t py, std::uint64_t index) noexcept
      : sampler(
            Sampler::at(task.settings.sampler, task.seed, py * task.scene.camera.film.width + px, index, task.nets)),
        offset(task.scene.camera.filter.sample(sampler.get_2d(slot(CameraDecision::pixel)))) {}

  /// Time of the sample in [0, 1], from the opening of the shutter to its closing; 0 if nothing moves.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE float time() const noexcept {
    return E.motion ? sampler.get_1d(slot(CameraDecision::time)) : 0.0F;
  }
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Ray ray(const Scene& scene, std::uint64_t px, std::uint64_t py,
                                         float time) const noexcept {
    return camera_ray<E>(
        scene.camera.sensor, scene.camera.motion, static_cast<double>(px) + 0.5 + offset.x,
        static_cast<double>(py) + 0.5 + offset.y, [&]() noexcept { return sampler.get_2d(slot(CameraDecision::lens)); },
        time);
  }
};

/// One sample of a pixel of the full film: the path's radiance times the filter's weight. NaN if Embree refused a ray
/// of the path: a refused ray reports no hit, so the radiance would be wrong.
template <Effects E, Observer O>
EQUALTIME_INLINE Spectrum sample_film_pixel(const BlockTask& task, std::uint64_t px, std::uint64_t py,
                                            std::uint64_t index, O& observer) {
  static_cast<void>(Accel::take_refusal());  // clears the flag of earlier rays on this thread
  const FilmSample begin(task, px, py, index);
  tell<event::PathStarted>(observer, begin.offset.weight);
  const float time = begin.time<E>();
  const Spectrum L = trace_path<E>(task.scene, task.settings, begin.ray<E>(task.scene, px, py, time), time,
                                   begin.sampler, PathCopies<E>(task.settings, px, py), observer);
  if (Accel::take_refusal()) [[unlikely]]
    return Spectrum(std::numeric_limits<float>::quiet_NaN());
  return L * begin.offset.weight;
}

/// One sample of a pixel of the crop.
template <Effects E, Observer O>
EQUALTIME_INLINE Spectrum sample_pixel(const BlockTask& task, std::uint32_t x, std::uint32_t y, std::uint64_t index,
                                       O& observer) {
  return sample_film_pixel<E>(task, x + task.scene.camera.film.crop_x, y + task.scene.camera.film.crop_y, index,
                              observer);
}

/// Adds the finite samples of a block, made by `sample(x, y, index)`, to the film, in ascending order. Samples of a
/// pixel's second net go to a film of their own. Ends early if a path was abandoned.
template <class Sample>
EQUALTIME_INLINE void render_samples(const BlockTask& task, Film& film, RayCounter& counter,
                                     SampleLog<NonFinite>& nonfinite, Sample&& sample) {
  const double scale = task.scene.normalization.world_radiance_scale();
  for (std::uint32_t y = task.block.y0; y < task.block.y1; ++y)
    for (std::uint32_t x = task.block.x0; x < task.block.x1; ++x) {
      const std::size_t pixel = std::size_t{y} * film.width() + x;
      const std::uint64_t first = task.schedule ? task.schedule->count(pixel, task.first) : task.first;
      const std::uint64_t last = task.schedule ? task.schedule->count(pixel, task.last) : task.last;
      const std::uint64_t rays = counter.counters.rays + counter.counters.shadow_rays;
      const int nets = task.second && task.second->has(x, y) ? 2 : 1;
      for (int net = 0; net < nets; ++net) {
        for (std::uint64_t i = first; i < last; ++i) {
          const std::uint64_t index = net == 0 ? i : kSecondNet + i;
          const Spectrum L = sample(x, y, index);
          if (counter.abandoned) [[unlikely]]
            return;
          if (L.is_finite()) {
            net == 0 ? film.add(x, y, i, L, scale) : task.second->add(x, y, i, L, scale);
          } else {
            ++counter.counters.nonfinite;
            nonfinite.add({x, y, index});
          }
        }
        if (net == 0 && task.pixel_rays)
          task.pixel_rays[pixel] += counter.counters.rays + counter.counters.shadow_rays - rays;
      }
    }
}

}  // namespace equaltime
