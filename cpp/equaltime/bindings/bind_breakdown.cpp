// Where the light of an image comes from, and where some may hide.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>

#include "equaltime/analysis/alpha.h"
#include "equaltime/analysis/light_breakdown.h"
#include "equaltime/analysis/specular.h"
#include "equaltime/analysis/unoccluded_light.h"
#include "equaltime/analysis/visible_emitters.h"
#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

py::tuple split(std::shared_ptr<Scene> scene, const Settings& settings, std::uint64_t seed, unsigned threads,
                std::uint64_t samples, std::uint32_t nets, bool only_lengths,
                const py::array_t<std::uint32_t, py::array::c_style>& surface_groups) {
  if (samples == 0) throw py::value_error("samples must be at least 1");
  const std::span<const std::uint32_t> groups(surface_groups.data(), static_cast<std::size_t>(surface_groups.size()));
  if (!groups.empty() && groups.size() != scene->geometry.surfaces.size())
    throw py::value_error("surface_groups has " + std::to_string(groups.size()) + " groups for " +
                          std::to_string(scene->geometry.surfaces.size()) + " shapes");
  auto measured = [&] {
    const py::gil_scoped_release release;
    return std::make_unique<LightBreakdown>(break_down_light(std::move(scene), settings,
                                                             {.seed = seed, .threads = threads, .nets = nets}, samples,
                                                             only_lengths, groups, check_signals));
  }();
  py::list names;
  for (const auto& [kind, what] : std::span(measured->parts.names()).first(measured->kept))
    names.append(py::make_tuple(kind, what));
  const std::size_t shape[] = {measured->height, measured->width, measured->kept, 3};
  const float* means = measured->means.data();
  const py::capsule owner(measured.get(), [](void* held) { delete static_cast<LightBreakdown*>(held); });
  (void)measured.release();  // the capsule deletes it from here on
  return py::make_tuple(names, py::array_t<float>(shape, means, owner));
}

py::array_t<float> alpha_of(std::shared_ptr<Scene> scene, const Settings& settings, std::uint64_t seed,
                            unsigned threads, std::uint64_t samples, std::uint32_t nets) {
  if (samples == 0) throw py::value_error("samples must be at least 1");
  const std::size_t shape[] = {scene->camera.film.crop_height, scene->camera.film.crop_width};
  const std::vector<float> found = [&] {
    const py::gil_scoped_release release;
    return alpha(std::move(scene), settings, {.seed = seed, .threads = threads, .nets = nets}, samples, check_signals);
  }();
  return py::array_t<float>(shape, found.data());
}

py::array_t<double> unseen(std::shared_ptr<Scene> scene, const Settings& settings,
                           const py::array_t<std::uint32_t, py::array::c_style>& pixels, std::uint64_t seed,
                           unsigned threads, std::uint32_t nets) {
  const std::size_t count = static_cast<std::size_t>(pixels.size());
  const std::size_t film = std::size_t{scene->camera.film.crop_width} * scene->camera.film.crop_height;
  const std::span<const std::uint32_t> asked(pixels.data(), count);
  if (std::any_of(asked.begin(), asked.end(), [film](std::uint32_t pixel) { return pixel >= film; }))
    throw py::value_error("a pixel is outside of the film");
  const std::vector<double> found = [&] {
    const py::gil_scoped_release release;
    return radiance_without_occlusion(std::move(scene), settings, {.seed = seed, .threads = threads, .nets = nets},
                                      asked);
  }();
  const std::size_t shape[] = {count, 3};
  return py::array_t<double>(shape, found.data());
}

/// Pixels, their moments, and of how many points these are made.
py::tuple arrays_of(const std::map<std::uint32_t, EmittersOfPixel>& found) {
  const auto count = static_cast<py::ssize_t>(found.size());
  py::array_t<std::uint32_t> pixels(count), made_of(count);
  py::array_t<double> moments({count, py::ssize_t{2}, py::ssize_t{3}});
  std::uint32_t *pixel_to = pixels.mutable_data(), *made_of_to = made_of.mutable_data();
  double* moment_to = moments.mutable_data();
  for (const auto& [pixel, emitters] : found) {
    *pixel_to++ = pixel;
    *made_of_to++ = emitters.points;
    moment_to = std::copy_n(emitters.mean, 3, moment_to);
    moment_to = std::copy_n(emitters.mean_square, 3, moment_to);
  }
  return py::make_tuple(pixels, moments, made_of);
}

py::tuple in_sight(const Scene& scene, const Settings& settings, std::uint64_t seed, std::uint64_t points,
                   bool whole_film) {
  std::map<std::uint32_t, EmittersOfPixel> found;
  {
    const py::gil_scoped_release release;
    found = find_visible_emitters(scene, settings, seed, points, whole_film);
  }
  return arrays_of(found);
}

py::tuple in_mirrors(const Scene& scene, const Settings& settings, std::uint64_t seed, unsigned threads,
                     std::uint64_t samples) {
  std::map<std::uint32_t, EmittersOfPixel> found;
  {
    const py::gil_scoped_release release;
    found = mirrored_emitters(scene, settings, {.seed = seed, .threads = threads}, samples);
  }
  return arrays_of(found);
}

py::tuple on_specular(const Scene& scene, const Settings& settings, std::uint64_t seed, unsigned threads,
                      std::uint64_t paths, bool whole_film) {
  FocusedLight found;
  {
    const py::gil_scoped_release release;
    found = focused_light(scene, settings, {.seed = seed, .threads = threads}, paths, whole_film);
  }
  return py::make_tuple(found.vertices, found.radiance, found.solid_angle);
}

}  // namespace

void bind_breakdown(py::module_& m) {
  m.def("alpha", &alpha_of, "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "samples"_a = 1, "nets"_a = 2,
        "How opaque each pixel is, (H, W) in [0, 1]: the share of a render's camera rays that meet something. "
        "Interrupts are honoured.");
  m.def("split_light", &split, "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "samples"_a = 1, "nets"_a = 2,
        "only_lengths"_a = false, py::arg_v("surface_groups", py::array_t<std::uint32_t>(0), "..."),
        "The image of so many samples by its parts: their names, (kind, what) each, and (H, W, parts, 3) means. The "
        "parts of each kind (length, way, bsdf, surface, light) add up to the image. `surface_groups` has the group of "
        "each shape, from 0; without any, all are one group. Interrupts are honoured.");
  m.def("unshadowed", &unseen, "scene"_a, "settings"_a, "pixels"_a, "seed"_a = 0, "threads"_a = 0, "nets"_a = 2,
        "(N, 3): what the first sample of each of these pixels (y * width + x of the crop) would be if nothing stood "
        "between surfaces and the lights that it aims at.");
  m.def("lamps_in_sight", &in_sight, "scene"_a, "settings"_a, "seed"_a = 0, "points"_a = 1, "whole_film"_a = false,
        "Emitters in direct sight, found by projecting points of them: the N pixels that see any (y * width + x of "
        "the crop, or of the whole film); the mean and the mean square of a sample of each, (N, 2, 3); and the number "
        "of points in each. Cameras other than pinholes and lenses that stand still find none.");
  m.def("mirrored_lamps", &in_mirrors, "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "samples"_a = 1,
        "Emitters that the camera sees by specular reflection and refraction alone, found by `samples` paths over "
        "specular vertices in all. Returns three arrays as lamps_in_sight does.");
  m.def("focused_light", &on_specular, "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "paths"_a = 1,
        "whole_film"_a = false,
        "(vertices, radiance, solid angle): how many of so many paths over the crop, or over the whole film, meet a "
        "specular surface, and the light of emitters there (FocusedLight of cpp/equaltime/analysis/specular.h).");
}

}  // namespace equaltime
