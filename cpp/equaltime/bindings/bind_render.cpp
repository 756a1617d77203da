// Settings, Renderer and what the build was made of.
#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cmath>
#include <map>

#include "equaltime/accel/instruction_set.h"
#include "equaltime/base/effects.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/math/elementary.h"
#include "equaltime/render/renderer.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

/// The value that a word names, or an error that lists the words; without a word, the value is left as it is.
template <class T>
void set(T& target, const std::map<std::string, T>& words, const std::optional<std::string>& word, const char* what) {
  if (!word) return;
  if (const auto it = words.find(*word); it != words.end()) {
    target = it->second;
    return;
  }
  std::string known;
  for (const auto& [name, value] : words) known += (known.empty() ? "" : ", ") + name;
  throw py::value_error(std::string(what) + " is one of " + known + ", not \"" + *word + "\"");
}

/// None stands for what has no meaning with the rest, such as the heuristic of a technique that needs no weights.
using Word = std::optional<std::string>;

Settings make_settings(const Word& technique, const Word& heuristic, const Word& lights, const Word& environment,
                       const Word& roulette, std::optional<int> roulette_depth, std::optional<float> survival,
                       int truncate, const Word& sampler, int max_depth) {
  Settings s;
  set(s.technique,
      {{"uniform", Technique::uniform},
       {"bsdf", Technique::bsdf},
       {"light", Technique::light},
       {"mis", Technique::mis},
       {"mixture", Technique::mixture}},
      technique, "technique");
  set(s.heuristic, {{"balance", Heuristic::balance}, {"power", Heuristic::power}}, heuristic, "heuristic");
  set(s.light_selection,
      {{"uniform", LightSelection::uniform}, {"power", LightSelection::power}, {"tree", LightSelection::tree}}, lights,
      "lights");
  set(s.environment_sampling,
      {{"plain", EnvironmentSampling::plain}, {"compensated", EnvironmentSampling::compensated}}, environment,
      "environment");
  if (s.environment_sampling == EnvironmentSampling::compensated && s.technique < Technique::mis)
    throw py::value_error("a compensated environment needs BSDF sampling beside it: mis or mixture");
  set(s.roulette,
      {{"none", Roulette::none},
       {"constant", Roulette::constant},
       {"albedo", Roulette::albedo},
       {"throughput", Roulette::throughput},
       {"efficiency", Roulette::efficiency},
       {"automatic", Roulette::automatic}},
      roulette, "roulette");
  set(s.sampler,
      {{"independent", SamplerKind::independent},
       {"stratified", SamplerKind::stratified},
       {"sobol", SamplerKind::sobol},
       {"lattice", SamplerKind::lattice}},
      sampler, "sampler");
  s.roulette_depth = roulette_depth.value_or(s.roulette_depth);
  s.survival = survival.value_or(s.survival);
  if (!(s.survival > 0 && s.survival <= 1)) throw py::value_error("survival is a probability above 0");
  s.max_depth = max_depth < 0 ? kUnlimitedDepth : max_depth;
  if (truncate > 0) s.max_depth = std::min(s.max_depth, truncate);
  return s;
}

Effects effects_of(const std::vector<std::string>& names) {
  Effects effects;
  for (const std::string& word : names) {
    const auto field = std::find_if(std::begin(kEffectFields), std::end(kEffectFields),
                                    [&](const EffectField& f) { return f.name == word; });
    if (field == std::end(kEffectFields)) throw py::value_error("no effect is called \"" + word + "\"");
    effects.*field->value = true;
  }
  return effects;
}

py::array moments_of(Film& film, const py::object& self) {
  return py::array_t<PixelMoments>({film.replicates(), film.height(), film.width()}, film.moments().data(), self);
}

py::array moments(const py::object& self) { return moments_of(self.cast<Renderer&>().film(), self); }
py::array second_moments(const py::object& self) {
  return moments_of(self.cast<Renderer&>().second_nets().film(), self);
}

py::array_t<std::int64_t> second_pixels(Renderer& r) {
  const Film& film = r.second_nets().film();
  return py::array_t<std::int64_t>({film.height(), film.width()}, r.second_nets().pixels().data());
}

py::dict counters(const Renderer& r) {
  const Counters& c = r.counters();
  return py::dict("paths"_a = c.paths, "rays"_a = c.rays, "shadow_rays"_a = c.shadow_rays, "nonfinite"_a = c.nonfinite);
}

py::list nonfinite(const Renderer& r) {
  py::list list;
  for (const NonFinite& n : r.nonfinite()) list.append(py::make_tuple(n.x, n.y, n.index));
  return list;
}

py::list faulty(const Renderer& r) {
  py::list list;
  for (const FaultySample& s : r.faulty()) list.append(py::make_tuple(s.x, s.y, s.index, fault_names(s.faults)));
  return list;
}

py::object decision(const Renderer& r) {
  static constexpr const char* kWords[] = {"none", "constant", "albedo", "throughput", "efficiency", "automatic"};
  const RouletteDecision* decided = r.decision();
  if (decided == nullptr) return py::none();
  const auto splitting = decided->log_ratio ? std::optional(elementary::exp(*decided->log_ratio)) : std::nullopt;
  return py::dict("roulette"_a = kWords[static_cast<std::size_t>(decided->roulette)], "splitting"_a = splitting,
                  "rays"_a = decided->rays + decided->shadow_rays);
}

py::dict build_info() {
#ifdef __OPTIMIZE__
  const char* optimized = "yes";
#else
  const char* optimized = "no";
#endif
#ifdef __clang__
  const char* compiler = "clang++ " __clang_version__;
#else
  const char* compiler = "g++ " __VERSION__;
#endif
  return py::dict("version"_a = EQUALTIME_VERSION, "compiler"_a = compiler, "optimized"_a = optimized,
                  "target"_a = EQUALTIME_TARGET, "embree"_a = Accel::version(), "embree_isa"_a = embree_isa());
}

void bind_methods(py::class_<Renderer>& renderer) {
  renderer
      .def(py::init([](std::shared_ptr<Scene> scene, const Settings& settings, std::uint64_t seed, unsigned threads,
                       std::uint32_t tile, std::uint32_t replicates, bool pixel_rays,
                       const std::vector<std::string>& also, const std::string& traps,
                       std::optional<std::uint32_t> nets, std::uint32_t second_net) {
             RenderOptions options{seed,       threads,         tile, replicates, nets.value_or(replicates), second_net,
                                   pixel_rays, effects_of(also)};
             set(options.traps, {{"ignore", Traps::ignore}, {"check", Traps::check}, {"stop", Traps::stop}}, traps,
                 "traps");
             return std::make_unique<Renderer>(std::move(scene), settings, options);
           }),
           "scene"_a, "settings"_a, "seed"_a = 0, "threads"_a = 0, "tile"_a = 16, "replicates"_a = 2,
           "pixel_rays"_a = false, "also"_a = py::tuple(), "traps"_a = "ignore", "nets"_a = py::none(),
           "second_net"_a = 0,
           "`also` names effects that the kernel must cover though the scene does not call for them. `nets` is 1, or "
           "as many as replicates; with 1, replicates are its halves, and one of `second_net` pixels (a power of two "
           "up to 32; 0: none) has a second.")
      .def(
          "advance",
          [](Renderer& r, std::uint64_t samples, std::optional<double> seconds, const std::optional<py::function>& poll,
             std::optional<double> pause) {
            const py::gil_scoped_release release;
            const auto asked = [&poll] {
              check_signals();
              const py::gil_scoped_acquire acquire;
              return !poll || (*poll)().cast<bool>();
            };
            return r.advance(samples, seconds, asked, pause);
          },
          "samples"_a, "seconds"_a = py::none(), "poll"_a = py::none(), "pause"_a = py::none())
      .def(
          "limit_to",
          [](Renderer& r, const std::tuple<std::uint32_t, std::uint32_t, std::uint32_t, std::uint32_t>& window) {
            const auto [x0, y0, x1, y1] = window;
            r.limit_to({x0, y0, x1, y1});
          },
          "window"_a,
          "Render only the window (x0, y0, x1, y1) of the film from here on, anew; counters start again at the pilot's "
          "rays. ValueError unless it is made of whole blocks.")
      .def(
          "resume",
          [](Renderer& r, std::uint64_t paths, std::uint64_t rays, std::uint64_t shadow_rays,
             const std::tuple<std::uint64_t, std::uint64_t, std::size_t>& position) {
            const auto [done, target, next_block] = position;
            r.resume({.paths = paths, .rays = rays, .shadow_rays = shadow_rays}, {done, target, next_block});
          },
          py::kw_only(), "paths"_a, "rays"_a, "shadow_rays"_a, "position"_a,
          "Takes up a render whose moments were written into `moments`; ValueError if no passes leave such counts.")
      .def(
          "set_sample_rates",
          [](Renderer& r, std::uint64_t pilot, const py::array_t<float, py::array::c_style>& rates) {
            r.set_sample_rates(pilot, {rates.data(), rates.data() + rates.size()});
          },
          "pilot"_a, "rates"_a, "From here on samples are averages: each pixel's grow at its rate, (H, W).");
}

void bind_properties(py::class_<Renderer>& renderer) {
  renderer
      .def_property_readonly(
          "position",
          [](const Renderer& r) { return std::tuple(r.position().done, r.position().target, r.position().next_block); },
          "(done, target, next block): every pixel has `done` samples, in the blocks before the next `target`.")
      .def_property_readonly("moments", &moments)
      .def_property_readonly("second_moments", &second_moments,
                             "Moments of the second nets of some pixels, (R, h, w); empty if there are none.")
      .def_property_readonly("second_pixels", &second_pixels,
                             "(h, w): the pixel, y * width + x, that each second net is of; -1: of none.")
      .def_property_readonly(
          "pixel_rays",
          [](const Renderer& r) {
            if (r.pixel_rays().empty()) throw py::value_error("made without pixel_rays, which counts them");
            const auto& film = r.scene().camera.film;
            return py::array_t<std::uint64_t>({film.crop_height, film.crop_width}, r.pixel_rays().data());
          },
          "(H, W): rays of each pixel since the renderer was made. Rays of second nets are left out. ValueError unless "
          "rays are counted.")
      .def_property_readonly("counters", &counters)
      .def_property_readonly("nonfinite", &nonfinite)
      .def_property_readonly("faulty", &faulty, "(x, y, index, what) of samples that raised floating-point faults.")
      .def_property_readonly("decision", &decision,
                             "Roulette, variance times rays with splitting over that without, and the pilot's rays; "
                             "None until it is decided, or where there was nothing to decide.")
      .def_property_readonly("kernel", [](const Renderer& r) { return kernel_name(r.kernel().effects); })
      .def_property_readonly("threads", &Renderer::threads);
}

}  // namespace

void bind_render(py::module_& m) {
  py::class_<Settings>(m, "Settings", "A strategy, as the core reads it.")
      .def(py::init(&make_settings), py::kw_only(), "technique"_a = "mis", "heuristic"_a = "power",
           "lights"_a = "power", "environment"_a = "plain", "roulette"_a = "throughput", "roulette_depth"_a = 5,
           "survival"_a = 0.75, "truncate"_a = 0, "sampler"_a = "lattice", "max_depth"_a = -1)
      .def_readonly("max_depth", &Settings::max_depth);
  py::class_<Renderer> renderer(m, "Renderer", "Brings a film to a number of samples, pass by pass.");
  bind_methods(renderer);
  bind_properties(renderer);
  m.def("hold_embree", &hold_embree, "isa"_a,
        "Hold Embree to an instruction set in all scenes built from now on: sse4.2, avx, avx2 or avx512.");
  m.def("build_info", &build_info, "What this module was built with: version, compiler, target, Embree.");
}

}  // namespace equaltime
