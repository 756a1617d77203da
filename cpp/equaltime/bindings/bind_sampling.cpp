// The parts of the estimator by themselves, over arrays: what tests need to hold each sampler against its density.
// Directions are unit; BSDFs are local (z along the normal), lights are in world space, in the scene's own units.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <map>
#include <string>

#include "equaltime/base/effects.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/render/checked.h"
#include "equaltime/sampling/mis.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Row i of an (N, columns) array, checked once by `count`.
Vec3f row(const Array& a, py::ssize_t i) {
  const double* p = a.data(i, 0);
  return Vec3f(Vec3d{p[0], p[1], p[2]});
}

py::ssize_t count(const Array& a, py::ssize_t columns, const char* what) {
  if (a.ndim() != 2 || a.shape(1) != columns)
    throw py::value_error(std::string(what) + " must have the shape (N, " + std::to_string(columns) + ")");
  return a.shape(0);
}

void require(bool good, const char* what) {
  if (!good) throw py::value_error(what);
}

/// Arrays that a loop fills row by row.
struct Columns {
  explicit Columns(py::ssize_t n) : direction({n, py::ssize_t{3}}), value({n, py::ssize_t{3}}), pdf(n), valid(n) {
    std::fill_n(direction.mutable_data(), 3 * n, 0.0);
    std::fill_n(value.mutable_data(), 3 * n, 0.0);
    std::fill_n(pdf.mutable_data(), n, 0.0);
    std::fill_n(valid.mutable_data(), n, false);
  }
  void set(py::ssize_t i, const Vec3f& d, const Spectrum& v, float p) {
    const double ds[3] = {d.x, d.y, d.z}, vs[3] = {v.r, v.g, v.b};
    std::copy_n(ds, 3, direction.mutable_data(i, 0));
    std::copy_n(vs, 3, value.mutable_data(i, 0));
    pdf.mutable_at(i) = p;
    valid.mutable_at(i) = true;
  }
  py::array_t<double> direction, value, pdf;
  py::array_t<bool> valid;
};

/// A BSDF by its number; after them, the phase functions of the media of any extinction.
Scatterer bsdf_at(const Scene& scene, std::size_t index) {
  const std::size_t materials = scene.appearance.materials.size();
  require(index < materials + scene.volumes.media.size(), "no such BSDF");
  return index < materials ? Scatterer(scene.appearance.materials[index].bsdf)
                           : Scatterer(scene.volumes.phases[index - materials]);
}

py::dict bsdf_values(const Scene& scene, std::size_t index, const Array& wo, const Array& wi, bool front) {
  const Scatterer bsdf = bsdf_at(scene, index);
  const py::ssize_t n = count(wo, 3, "wo");
  require(count(wi, 3, "wi") == n, "as many wi as wo");
  Columns out(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const BsdfValue<float> v =
        visit<kAllEffects>(bsdf, [&](const auto& m) { return m.eval(row(wo, i), row(wi, i), front); });
    out.set(i, row(wi, i), v.f_cos, v.pdf);
  }
  return py::dict("f"_a = out.value, "pdf"_a = out.pdf);
}

py::dict bsdf_samples(const Scene& scene, std::size_t index, const Array& wo, const Array& u, bool front) {
  const Scatterer bsdf = bsdf_at(scene, index);
  const py::ssize_t n = count(wo, 3, "wo");
  require(count(u, 3, "u") == n, "as many u as wo");
  Columns out(n);
  py::array_t<bool> delta(n);
  py::array_t<double> scale(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const Vec3f x = row(u, i);
    const auto s = visit<kAllEffects>(bsdf, [&](const auto& m) {
      return m.sample(row(wo, i), front, *u.data(i, 0), {x.y, x.z});
    });
    delta.mutable_at(i) = s && s->delta;
    scale.mutable_at(i) = s ? static_cast<double>(s->eta_scale) : 1.0;
    if (s) out.set(i, s->wi, s->weight, s->pdf);
  }
  return py::dict("wi"_a = out.direction, "weight"_a = out.value, "pdf"_a = out.pdf, "valid"_a = out.valid,
                  "delta"_a = delta, "radiance_scale"_a = scale);
}

/// How lights are sampled, by name.
struct LightChoice {
  LightSelection lights;
  EnvironmentSampling environment;
};

EnvironmentSampling environment_sampling(const std::string& name) {
  require(name == "plain" || name == "compensated", "an environment is sampled \"plain\" or \"compensated\"");
  return name == "plain" ? EnvironmentSampling::plain : EnvironmentSampling::compensated;
}

LightChoice choice(const Scene& scene, const std::string& lights, const std::string& environment) {
  require(lights == "uniform" || lights == "power" || lights == "tree",
          "lights are picked by \"uniform\", \"power\" or \"tree\"");
  const LightSelection select = lights == "uniform" ? LightSelection::uniform
                                : lights == "power" ? LightSelection::power
                                                    : LightSelection::tree;
  const EnvironmentSampling sampling = environment_sampling(environment);
  scene.lights.prepare(select, sampling);
  return {select, sampling};
}

/// Points that gather light, in the scene's own space: opaque where they have a normal.
struct Receivers {
  Receivers(const Scene& in, const Array& at, const std::optional<Array>& facing)
      : scene(in), points(at), normals(facing), size(count(at, 3, "receivers")) {
    require(!normals || count(*normals, 3, "normals") == size, "as many normals as receivers");
  }
  [[nodiscard]] LightSampleContext operator[](py::ssize_t i) const {
    const double* p = points.data(i, 0);
    const Vec3f point(scene.normalization.point({p[0], p[1], p[2]}));
    return {point, normals ? row(*normals, i) : Vec3f(), normals.has_value()};
  }
  const Scene& scene;
  const Array& points;
  const std::optional<Array>& normals;
  py::ssize_t size;
};

/// As a path does at bounce 0: `seed` and the row make the numbers.
py::dict sample_lights(const Scene& scene, const std::string& lights, const Array& places, std::uint64_t seed,
                       const std::optional<Array>& normals, const std::string& environment) {
  const LightChoice by = choice(scene, lights, environment);
  const Receivers receivers(scene, places, normals);
  Columns out(receivers.size);
  const double scale = scene.normalization.world_radiance_scale();
  for (py::ssize_t i = 0; i < receivers.size; ++i) {
    const Sampler sampler = Sampler::at(SamplerKind::independent, seed, 0, static_cast<std::uint64_t>(i), 1);
    const float time = sampler.get_1d(slot(CameraDecision::time));
    const LightSampleContext receiver = receivers[i];
    const auto s = scene.lights.sample<kAllEffects>(by.lights, by.environment,
                                                    {receiver, sampler, 0, sampler.vertex(0).light_point, time});
    if (s) out.set(i, s->wi, scene.radiance_of(*s, time) * static_cast<float>(scale), s->pdf);
  }
  return py::dict("wi"_a = out.direction, "radiance"_a = out.value, "pdf"_a = out.pdf, "valid"_a = out.valid);
}

/// What a ray from each receiver meets of the lights, and the density of `sample_lights` for its direction.
py::dict eval_lights(const Scene& scene, const std::string& lights, const Array& places, const Array& wi,
                     const std::optional<Array>& normals, const std::string& environment) {
  const LightChoice by = choice(scene, lights, environment);
  const Receivers receivers(scene, places, normals);
  require(count(wi, 3, "wi") == receivers.size, "as many wi as receivers");
  Columns out(receivers.size);
  const auto scale = static_cast<float>(scene.normalization.world_radiance_scale());
  for (py::ssize_t i = 0; i < receivers.size; ++i) {
    const LightSampleContext receiver = receivers[i];
    const Vec3f d = row(wi, i);
    const Optional<Interaction> it = scene.geometry.closest<kAllEffects>({receiver.p, d}, 0).it;
    if (!it) {
      if (!scene.lights.environment()) continue;
      const LightValue<float> v = scene.lights.environment_towards(by.lights, by.environment, receiver, d);
      out.set(i, d, v.radiance * scale, v.pdf);
    } else if (it->front && scene.geometry.emits(*it)) {
      const float pdf =
          scene.lights.area_pdf<kAllEffects>(by.lights, scene.geometry.light_of(*it), receiver, d, it->anchor.p, 0);
      out.set(i, d, scene.radiance<kAllEffects>(*it) * scale, pdf);
    }
  }
  return py::dict("radiance"_a = out.value, "pdf"_a = out.pdf, "valid"_a = out.valid);
}

/// Density at wi of the directions that one-sample MIS draws towards an area light or the environment, without its
/// pick; -1 where there are none.
py::array_t<double> direction_densities(const Scene& scene, std::uint32_t light, const Array& places, const Array& wi,
                                        const std::string& environment) {
  const EnvironmentSampling sampling = choice(scene, "uniform", environment).environment;
  const std::optional<Array> no_normals;
  const Receivers receivers(scene, places, no_normals);
  require(count(wi, 3, "wi") == receivers.size, "as many wi as receivers");
  require(light < scene.lights.size(), "no such light");
  py::array_t<double> out(receivers.size);
  for (py::ssize_t i = 0; i < receivers.size; ++i) {
    const bool drawn = scene.lights.has_directions<kAllEffects>(light, receivers[i], 0);
    out.mutable_at(i) =
        drawn ? scene.lights.pdf_direction<kAllEffects>(light, sampling, receivers[i], row(wi, i), 0) : -1.0F;
  }
  return out;
}

/// Flights of rays of a throughput through a medium, numbered among those of any extinction, to a surface at so many
/// of the user's units of length, with two numbers a row.
py::dict sample_flights(const Scene& scene, std::size_t medium, const Array& beta, const Array& distance,
                        const Array& u) {
  require(medium < scene.volumes.media.size(), "no such medium");
  const py::ssize_t n = count(u, 2, "u");
  require(count(beta, 3, "beta") == n && distance.ndim() == 1 && distance.shape(0) == n, "as many beta and distances");
  Columns out(n);
  py::array_t<double> reach(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const Vec3f b = row(beta, i);
    const auto most = static_cast<float>(scene.normalization.length(distance.at(i)));
    const DistanceSample f = scene.volumes.media[medium].sample({b.x, b.y, b.z}, most, {*u.data(i, 0), *u.data(i, 1)});
    out.set(i, {}, f.weight, 0);
    out.valid.mutable_at(i) = f.scattered;
    reach.mutable_at(i) = scene.normalization.world_length(static_cast<double>(f.distance));
  }
  return py::dict("weight"_a = out.value, "collides"_a = out.valid, "distance"_a = reach);
}

/// Places within a pixel that the scene's filter draws, in pixels from its centre, and their weights.
py::dict sample_filter(const Scene& scene, const Array& u) {
  const py::ssize_t n = count(u, 2, "u");
  py::array_t<double> offset({n, py::ssize_t{2}}), weight(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const double* p = u.data(i, 0);
    const PixelFilter::Offset o = scene.camera.filter.sample({static_cast<float>(p[0]), static_cast<float>(p[1])});
    offset.mutable_at(i, 0) = o.x;
    offset.mutable_at(i, 1) = o.y;
    weight.mutable_at(i) = o.weight;
  }
  return py::dict("offset"_a = offset, "weight"_a = weight);
}

/// Camera rays through places on the full film, in pixels, with the lens numbers given: as a path gets them, but in
/// world space and in the scene's own units. Each is where the ray begins, its direction and its length.
py::dict camera_rays(const Scene& scene, const Array& places, const Array& lens, float time) {
  const py::ssize_t n = count(places, 2, "places");
  require(count(lens, 2, "lens") == n, "as many lens numbers as places");
  py::array_t<double> origin({n, py::ssize_t{3}}), direction({n, py::ssize_t{3}}), reach(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const double *p = places.data(i, 0), *u = lens.data(i, 0);
    const auto on_lens = [&]() noexcept { return Point2f{static_cast<float>(u[0]), static_cast<float>(u[1])}; };
    const Ray ray = camera_ray<kAllEffects>(scene.camera.sensor, scene.camera.motion, p[0], p[1], on_lens, time);
    const Vec3d o = scene.normalization.world_point(Vec3d(ray.origin)), d(ray.direction);
    std::copy_n(&o.x, 3, origin.mutable_data(i, 0));
    std::copy_n(&d.x, 3, direction.mutable_data(i, 0));
    reach.mutable_at(i) = scene.normalization.world_length(static_cast<double>(ray.t_max));
  }
  return py::dict("origin"_a = origin, "direction"_a = direction, "length"_a = reach);
}

/// The two numbers of a slot for samples 0 … n-1 of a pixel.
py::array_t<double> sample_numbers(const std::string& kind, std::uint64_t seed, std::uint64_t pixel, py::ssize_t n,
                                   std::uint32_t slot_index, std::uint32_t nets, std::uint64_t first) {
  static const std::map<std::string, SamplerKind> kinds = {{"independent", SamplerKind::independent},
                                                           {"stratified", SamplerKind::stratified},
                                                           {"sobol", SamplerKind::sobol},
                                                           {"lattice", SamplerKind::lattice}};
  const auto found = kinds.find(kind);
  require(found != kinds.end(), "a sampler is \"independent\", \"stratified\", \"sobol\" or \"lattice\"");
  py::array_t<double> out({n, py::ssize_t{2}});
  for (py::ssize_t i = 0; i < n; ++i) {
    const Point2f p =
        Sampler::at(found->second, seed, pixel, first + static_cast<std::uint64_t>(i), nets).get_2d({slot_index});
    out.mutable_at(i, 0) = p.x;
    out.mutable_at(i, 1) = p.y;
  }
  return out;
}

}  // namespace

void bind_sampling(py::module_& m) {
  py::module_ parts = m.def_submodule("parts", "The parts of the estimator by themselves, over arrays, for tests.");
  parts.def("eval_bsdf", &bsdf_values, "scene"_a, "bsdf"_a, "wo"_a, "wi"_a, "front"_a = true);
  parts.def("sample_bsdf", &bsdf_samples, "scene"_a, "bsdf"_a, "wo"_a, "u"_a, "front"_a = true);
  parts.def("sample_lights", &sample_lights, "scene"_a, "lights"_a, "receivers"_a, "seed"_a, "normals"_a = py::none(),
            "environment"_a = "plain");
  parts.def("eval_lights", &eval_lights, "scene"_a, "lights"_a, "receivers"_a, "wi"_a, "normals"_a = py::none(),
            "environment"_a = "plain");
  parts.def("direction_densities", &direction_densities, "scene"_a, "light"_a, "receivers"_a, "wi"_a,
            "environment"_a = "plain");
  parts.def("sample_flights", &sample_flights, "scene"_a, "medium"_a, "beta"_a, "distance"_a, "u"_a);
  parts.def(
      "take_faults", [] { return fault_names(take_faults()); }, "This thread's floating-point faults since.");
  parts.def("sample_filter", &sample_filter, "scene"_a, "u"_a);
  parts.def("camera_rays", &camera_rays, "scene"_a, "places"_a, "lens"_a, "time"_a = 0.0F);
  parts.def("sample_numbers", &sample_numbers, "kind"_a, "seed"_a, "pixel"_a, "count"_a, "slot"_a, "nets"_a = 1,
            "first"_a = 0);
  parts.def(
      "mis_weight",
      [](const std::string& heuristic, float pdf, float other) {
        return mis_weight(heuristic == "power" ? Heuristic::power : Heuristic::balance, pdf, other);
      },
      "heuristic"_a, "pdf"_a, "other"_a);
}

}  // namespace equaltime
