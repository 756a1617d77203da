// The limit ratio.
#include <pybind11/pybind11.h>

#include "equaltime/analysis/limit.h"
#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

py::dict as_dict(const LimitPair& pair) {
  const Counters& c = pair.counters;
  return py::dict("render_seconds"_a = pair.render_seconds, "replay_seconds"_a = pair.replay_seconds,
                  "paths"_a = c.paths, "rays"_a = c.rays, "shadow_rays"_a = c.shadow_rays, "found"_a = pair.found);
}

py::dict limit(std::shared_ptr<Scene> scene, const Settings& settings, std::uint64_t seed, unsigned threads,
               std::uint32_t tile, std::uint64_t samples, std::uint32_t pairs, std::size_t memory_bytes,
               bool replay_first) {
  if (samples == 0 || pairs == 0) throw py::value_error("samples and pairs must be at least 1");
  const RenderOptions render{.seed = seed, .threads = threads, .tile = tile};
  const LimitOptions options{samples, pairs, memory_bytes, replay_first};
  Limit measured;
  {
    const py::gil_scoped_release release;
    measured = measure_limit(std::move(scene), settings, render, options, check_signals);
  }
  py::list list;
  for (const LimitPair& pair : measured.pairs) list.append(as_dict(pair));
  return py::dict("samples"_a = samples, "threads"_a = measured.threads, "kernel"_a = kernel_name(measured.kernel),
                  "pairs"_a = list);
}

}  // namespace

void bind_bench(py::module_& m) {
  m.def("measure_limit", &limit, "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "tile"_a = 16,
        "samples"_a = 16, "pairs"_a = 9, "memory_bytes"_a = std::size_t{512} << 20U, "replay_first"_a = false,
        "Time renders, and Embree alone on the very rays of each, in turn: {samples, threads, kernel, pairs: "
        "[{render_seconds, replay_seconds, paths, rays, shadow_rays, found}]}. Interrupts are honoured.");
}

}  // namespace equaltime
