// One sample as plain data, in the author's units.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "equaltime/analysis/replay.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/render/checked.h"
#include "equaltime/scene/scene.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

py::tuple triple(const Vec3d& v) { return py::make_tuple(v.x, v.y, v.z); }
py::tuple triple(const Vec3f& v) { return triple(Vec3d(v)); }
py::tuple number(const Spectrum& s, double scale = 1) {
  return triple(Vec3d(static_cast<double>(s.r), static_cast<double>(s.g), static_cast<double>(s.b)) * scale);
}
template <class T>
py::object numbered(T index) {
  return index == kNone ? py::object(py::none()) : py::object(py::int_(index));
}

constexpr const char* kEnds[] = {"escapes", "depth", "absorbed", "no_direction", "black", "not_finite", "roulette"};

class Report {
 public:
  explicit Report(const Scene& scene) : scene_(scene), radiance_(scene.normalization.world_radiance_scale()) {}

  py::dict all(const Replay& r) const {
    py::list vertices;
    for (const TracedVertex& vertex : r.vertices) vertices.append(of(vertex));
    return py::dict("filter_weight"_a = r.filter_weight, "radiance"_a = number(r.radiance, radiance_),
                    "end"_a = kEnds[static_cast<std::size_t>(r.end)], "vertices"_a = vertices);
  }

 private:
  py::tuple point(const Vec3f& p) const { return triple(scene_.normalization.world_point(Vec3d(p))); }

  py::dict of(const TracedVertex& v) const {
    py::dict d("origin"_a = point(v.ray.origin), "direction"_a = triple(v.ray.direction),
               "throughput"_a = number(v.beta), "gathered"_a = number(v.L, radiance_));
    d["left"] = number(v.left);
    d["faults"] = fault_names(v.faults);
    d["from"] = v.from ? py::object(py::int_(*v.from)) : py::none();
    d["surface"] = v.it && !v.in_medium ? py::object(of(*v.it, v.prim_uv)) : py::none();
    d["particle"] = v.in_medium ? py::object(point(v.it->anchor.p)) : py::none();
    d["emitter"] = v.emitter ? py::object(of(*v.emitter)) : py::none();
    d["light"] = v.light ? py::object(of(*v.light)) : py::none();
    d["scattering"] = v.scattering ? py::object(of(*v.scattering)) : py::none();
    return d;
  }
  py::dict of(const Interaction& it, const std::optional<Point2f>& prim_uv) const {
    return py::dict("point"_a = point(it.anchor.p), "shape"_a = it.shape, "primitive"_a = it.primitive,
                    "instance"_a = numbered(it.instance),
                    "uv"_a = prim_uv ? py::object(py::make_tuple(prim_uv->x, prim_uv->y)) : py::none(),
                    "normal"_a = triple(it.anchor.n), "shading_normal"_a = triple(it.frame.n), "front"_a = it.front,
                    "offset"_a = scene_.normalization.world_length(static_cast<double>(it.anchor.offset)));
  }
  py::dict light(std::uint32_t index) const {
    const Lights& lights = scene_.lights;
    const bool environment = lights.environment() && index == lights.environment_index();
    const bool area = index < lights.first_delta();
    return py::dict("index"_a = index,
                    "kind"_a = environment ? "environment"
                               : area      ? "area"
                                           : "delta",
                    "shape"_a = numbered(shape_of_light(scene_, index)), "delta"_a = index - lights.first_delta());
  }
  py::dict of(const TracedEmitter& e) const {
    return py::dict("light"_a = light(e.light), "radiance"_a = number(e.radiance, radiance_),
                    "light_pdf"_a = e.light_pdf, "mis_weight"_a = e.weight,
                    "gathered"_a = number(e.gathered, radiance_));
  }
  py::dict of(const TracedLight& l) const {
    py::dict d("light"_a = light(l.pick.light), "pmf"_a = l.pick.pmf, "sampled"_a = l.sample.has_value());
    if (!l.sample) return d;
    const double distance = scene_.normalization.world_length(static_cast<double>(l.sample->distance));
    d["direction"] = triple(l.sample->wi);
    d["distance"] = l.sample->infinite ? py::object(py::none()) : py::object(py::float_(distance));
    d["pdf"] = l.sample->pdf;
    d["radiance"] = number(l.radiance, radiance_);
    d["bsdf"] = number(l.bsdf.f_cos);
    d["bsdf_pdf"] = l.bsdf.pdf;
    d["mis_weight"] = l.weight;
    d["visible"] = l.visibility;
    d["blocker"] = l.closest_occluder ? py::object(of(*l.closest_occluder, {})) : py::none();
    d["gathered"] = number(l.gathered, radiance_);
    return d;
  }
  py::dict of(const TracedScattering& s) const {
    py::dict d("bsdf"_a = s.bsdf, "shading_normal"_a = triple(s.it.frame.n), "albedo"_a = number(s.albedo),
               "sampled"_a = s.scattered.has_value());
    if (!s.scattered) return d;
    d["direction"] = triple(s.scattered->wi);
    d["above"] = s.scattered->above;
    d["pdf"] = s.scattered->delta ? py::object(py::none()) : py::object(py::float_(s.scattered->pdf));
    d["weight"] = number(s.scattered->weight);
    d["radiance_scale"] = s.scattered->eta_scale;
    d["survival"] = s.survival ? py::object(py::float_(*s.survival)) : py::none();
    return d;
  }

  const Scene& scene_;
  double radiance_;
};

py::dict replayed(const Scene& scene, const Settings& settings, std::uint64_t seed, std::uint32_t x, std::uint32_t y,
                  std::uint64_t index, std::uint32_t nets) {
  if (x >= scene.camera.film.crop_width || y >= scene.camera.film.crop_height || nets == 0)
    throw py::value_error("the pixel is not on the film");
  return Report(scene).all(replay(scene, settings, seed, x, y, index, nets));
}

}  // namespace

void bind_replay(py::module_& m) {
  m.def("replay", &replayed, "scene"_a, "settings"_a, "seed"_a, "x"_a, "y"_a, "index"_a, "nets"_a = 2,
        "One sample of a pixel of the crop, vertex by vertex with every factor, in the author's units.");
}

}  // namespace equaltime
