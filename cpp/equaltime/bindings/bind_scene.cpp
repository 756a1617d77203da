// SceneBuilder fills a SceneDescription from NumPy arrays; Scene is the compiled result.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <set>

#include "equaltime/base/effects.h"
#include "equaltime/base/run_blocks.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/build/build_scene.h"
#include "equaltime/build/check_description.h"
#include "equaltime/scene/derive_effects.h"
#include "equaltime/scene/output_albedo.h"
#include "equaltime/scene/scene.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using Triple = std::array<double, 3>;
using ArrayD = py::array_t<double, py::array::c_style | py::array::forcecast>;
using ArrayU = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;
using ArrayF = py::array_t<float, py::array::c_style | py::array::forcecast>;

Vec3d vec(const Triple& t) { return {t[0], t[1], t[2]}; }

/// The rows of an (N, 3) or (N, 2) array as vectors.
template <class Out, int Columns = 3, class Array>
std::vector<Out> rows(const Array& a, const char* what) {
  if (a.ndim() != 2 || a.shape(1) != Columns)
    throw py::value_error(std::string(what) + " must have the shape (N, " + std::to_string(Columns) + ")");
  static_assert(sizeof(Out) == Columns * sizeof(*a.data()));
  std::vector<Out> out(static_cast<std::size_t>(a.shape(0)));
  std::copy_n(a.data(), a.size(), reinterpret_cast<typename Array::value_type*>(out.data()));
  return out;
}

SurfaceDescription surface(std::optional<std::uint32_t> front, std::optional<std::uint32_t> back,
                           const std::optional<Triple>& radiance) {
  SurfaceDescription s{front, back, {}};
  if (radiance) s.radiance = vec(*radiance);
  return s;
}

/// The surface of a shape, which media, priorities and pictures that shine are of.
SurfaceDescription& solid(SceneDescription& d, std::uint32_t shape) {
  if (shape >= d.shapes.size()) throw py::value_error("a surface is that of a shape that was added");
  SurfaceDescription* s = std::visit(
      [](auto& any) -> SurfaceDescription* {
        if constexpr (requires { any.surface; }) return &any.surface;
        return nullptr;
      },
      d.shapes[shape]);
  if (s == nullptr) throw py::value_error("an instance has no surface of its own");
  return *s;
}

template <class T, class... Args>
std::uint32_t append(std::vector<T>& list, Args&&... args) {
  list.emplace_back(std::forward<Args>(args)...);
  return static_cast<std::uint32_t>(list.size() - 1);
}

ImageEnvironmentDescription image_environment(const ArrayF& pixels, double scale, const ArrayD& to_world) {
  if (pixels.ndim() != 3 || pixels.shape(2) != 3 || pixels.size() == 0)
    throw py::value_error("an environment image has the shape (H, W, 3)");
  ImageEnvironmentDescription d;
  d.height = static_cast<std::uint32_t>(pixels.shape(0));
  d.width = static_cast<std::uint32_t>(pixels.shape(1));
  d.pixels.resize(static_cast<std::size_t>(d.width) * d.height);
  std::copy_n(pixels.data(), pixels.size(), &d.pixels[0].r);
  d.scale = scale;
  d.to_world = transform(to_world);
  return d;
}

/// All that a scene may call for; splitting is the strategy's.
py::dict effects_dict(const Effects& e) {
  py::dict d;
  for (const auto& [used, name] : kEffectFields)
    if (used != &Effects::splitting) d[name] = e.*used;
  return d;
}

/// Where results go, one row a ray; null for those that nobody asked for.
struct HitTables {
  double *t, *p, *n, *shading_normal, *uv, *albedo, *dp_du, *dp_dv;
  std::int64_t *shape, *primitive;
  bool* front;
};

template <class V>
void put(double* table, std::size_t row, const V* first, std::size_t width) {
  if (table != nullptr) std::copy_n(first, width, table + width * row);
}

void put_hit(const Scene& scene, const HitTables& to, std::size_t i, const Vec3d& origin, const Vec3d& direction,
             float time) {
  const Ray ray{Vec3f(scene.normalization.point(origin)), Vec3f(normalize(direction))};
  const auto it = scene.geometry.closest<kAllEffects>(ray, time).it;
  const Vec3d point = it ? scene.normalization.world_point(Vec3d(it->anchor.p)) : Vec3d{};
  const Vec3f normal = it ? it->anchor.n : Vec3f{}, shading_normal = it ? it->frame.n : Vec3f{};
  const double t = it ? length(point - origin) : std::numeric_limits<double>::infinity();
  put(to.t, i, &t, 1);
  put(to.p, i, &point.x, 3);
  put(to.n, i, &normal.x, 3);
  put(to.shading_normal, i, &shading_normal.x, 3);
  const std::uint32_t shown = it ? scene.geometry.surfaces[it->shape].source_shape : kNone;
  if (to.shape != nullptr) to.shape[i] = it ? static_cast<std::int64_t>(shown != kNone ? shown : it->shape) : -1;
  if (to.primitive != nullptr) to.primitive[i] = it ? static_cast<std::int64_t>(it->primitive) : -1;
  if (to.front != nullptr) to.front[i] = it && it->front;
  if (to.uv != nullptr) {
    const Point2f place = it ? scene.geometry.texture_coords(*it).uv : Point2f{};
    put(to.uv, i, &place.x, 2);
  }
  if (to.albedo != nullptr) {
    const Spectrum color = it ? output_albedo<kAllEffects>(scene, scene.geometry.material(*it), *it) : Spectrum{};
    put(to.albedo, i, &color.r, 3);
  }
  if (to.dp_du == nullptr && to.dp_dv == nullptr) return;
  const double unit = scene.normalization.world_length(1);
  const Derivatives moves = it ? scene.geometry.derivatives(*it, time) : Derivatives{};
  const Vec3d du = Vec3d(moves.du) * unit, dv = Vec3d(moves.dv) * unit;
  put(to.dp_du, i, &du.x, 3);
  put(to.dp_dv, i, &dv.x, 3);
}

/// Nearest hits of rays given in the user's units: for tests, comparisons and outputs beside the image. Normals are on
/// the side of the ray.
py::dict nearest_hits(const Scene& scene, const ArrayD& origins, const ArrayD& directions, float time,
                      const std::optional<std::set<std::string>>& only, unsigned threads) {
  const auto o = rows<Vec3d>(origins, "origins"), d = rows<Vec3d>(directions, "directions");
  if (o.size() != d.size()) throw py::value_error("as many directions as origins");
  const auto n = static_cast<py::ssize_t>(o.size());
  py::dict found;
  const auto table = [&]<class T>(const char* name, T, py::ssize_t width) -> T* {
    if (only && !only->contains(name)) return nullptr;
    py::array_t<T> array = width == 0 ? py::array_t<T>(n) : py::array_t<T>({n, width});
    found[name] = array;
    return array.mutable_data();
  };
  const HitTables to{table("t", 0.0, 0),
                     table("p", 0.0, 3),
                     table("n", 0.0, 3),
                     table("shading_normal", 0.0, 3),
                     table("uv", 0.0, 2),
                     table("albedo", 0.0, 3),
                     table("dp_du", 0.0, 3),
                     table("dp_dv", 0.0, 3),
                     table("shape", std::int64_t{}, 0),
                     table("primitive", std::int64_t{}, 0),
                     table("front", false, 0)};
  constexpr std::size_t kBlock = 1024;
  const py::gil_scoped_release release;
  run_items(o.size(), kBlock, thread_count(threads),
            [&] { return [&](std::size_t i) { put_hit(scene, to, i, o[i], d[i], time); }; });
  return found;
}

using Builder = py::class_<SceneDescription>;
using Index = std::optional<std::uint32_t>;
using D = SceneDescription;

void bind_shapes(Builder& builder) {
  builder
      .def(
          "add_mesh",
          [](D& d, const ArrayD& vertices, const ArrayU& faces, const std::optional<ArrayD>& normals,
             const std::optional<ArrayD>& uvs, Index front, Index back, const std::optional<Triple>& radiance) {
            MeshDescription mesh;
            mesh.vertices = rows<Vec3d>(vertices, "vertices");
            mesh.triangles = rows<std::array<std::uint32_t, 3>>(faces, "faces");
            if (normals) mesh.normals = rows<Vec3d>(*normals, "normals");
            if (uvs) mesh.uvs = rows<std::array<double, 2>, 2>(*uvs, "uvs");
            mesh.surface = surface(front, back, radiance);
            return append(d.shapes, std::move(mesh));
          },
          "vertices"_a, "faces"_a, "normals"_a = py::none(), "uvs"_a = py::none(), py::kw_only(), "front"_a, "back"_a,
          "radiance"_a)
      .def(
          "add_rectangle",
          [](D& d, const ArrayD& t, bool flip, Index front, Index back, const std::optional<Triple>& radiance) {
            return append(d.shapes, RectangleDescription{transform(t), flip, surface(front, back, radiance)});
          },
          "to_world"_a, py::kw_only(), "flip_normals"_a, "front"_a, "back"_a, "radiance"_a)
      .def(
          "add_disk",
          [](D& d, const ArrayD& t, bool flip, Index front, Index back, const std::optional<Triple>& radiance) {
            return append(d.shapes, DiskDescription{transform(t), flip, surface(front, back, radiance)});
          },
          "to_world"_a, py::kw_only(), "flip_normals"_a, "front"_a, "back"_a, "radiance"_a)
      .def(
          "add_sphere",
          [](D& d, const Triple& c, double r, bool flip, Index front, Index back, const std::optional<Triple>& radiance,
             const Triple& pole, const Triple& meridian, bool mirrored) {
            return append(d.shapes, SphereDescription{vec(c), r, flip, surface(front, back, radiance), vec(pole),
                                                      vec(meridian), mirrored});
          },
          "center"_a, "radius"_a, py::kw_only(), "flip_normals"_a, "front"_a, "back"_a, "radiance"_a,
          "pole"_a = Triple{0, 0, 1}, "meridian"_a = Triple{1, 0, 0}, "mirrored"_a = false)
      .def(
          "add_cylinder",
          [](D& d, const Triple& base, const Triple& end, double r, bool flip, Index front, Index back,
             const std::optional<Triple>& radiance, const Triple& meridian, bool mirrored) {
            return append(d.shapes, CylinderDescription{vec(base), vec(end), r, flip, surface(front, back, radiance),
                                                        vec(meridian), mirrored});
          },
          "base"_a, "end"_a, "radius"_a, py::kw_only(), "flip_normals"_a, "front"_a, "back"_a, "radiance"_a,
          "meridian"_a = Triple{1, 0, 0}, "mirrored"_a = false);
}

void bind_surfaces(Builder& builder) {
  builder
      .def(
          "set_media",
          [](D& d, std::uint32_t shape, Index exterior, Index interior) {
            SurfaceDescription& s = solid(d, shape);
            s.exterior = exterior, s.interior = interior;
          },
          "shape"_a, py::kw_only(), "exterior"_a, "interior"_a)
      .def(
          "bind_radiance", [](D& d, std::uint32_t shape, std::uint32_t texture) { solid(d, shape).emission = texture; },
          "shape"_a, "texture"_a)
      .def(
          "set_priority", [](D& d, std::uint32_t shape, int priority) { solid(d, shape).priority = priority; },
          "shape"_a, "priority"_a)
      .def(
          "set_camera_medium", [](D& d, std::uint32_t medium) { d.camera_medium = medium; }, "medium"_a)
      .def("cross_freely", [](D& d) { d.count_null_interfaces = false; })
      .def("hide_emitters", [](D& d) { d.hides_emitters = true; })
      .def("keep_uvs", [](D& d) { d.keeps_uvs = true; });
}

void bind_groups(Builder& builder) {
  builder
      .def(
          "add_group",
          [](D& d, std::uint32_t first) {
            if (first > d.shapes.size()) throw py::value_error("a group begins with a shape that was added");
            GroupDescription group;
            const auto begin = d.shapes.begin() + first;
            group.shapes.assign(std::make_move_iterator(begin), std::make_move_iterator(d.shapes.end()));
            d.shapes.erase(begin, d.shapes.end());
            return append(d.groups, std::move(group));
          },
          "first_shape"_a, "Make the shapes from this one on a group, which is seen where instances put it.")
      .def(
          "add_instance",
          [](D& d, std::uint32_t group, const ArrayD& t) {
            return append(d.shapes, InstanceDescription{group, transform(t)});
          },
          "group"_a, "to_world"_a);
}

void bind_lights(Builder& builder) {
  builder
      .def(
          "add_point_light",
          [](D& d, const Triple& p, const Triple& i) {
            return append(d.point_lights, PointLightDescription{vec(p), vec(i)});
          },
          "position"_a, "intensity"_a)
      .def(
          "add_spot_light",
          [](D& d, const Triple& position, const Triple& direction, const Triple& intensity, double cutoff,
             double beam) {
            return append(d.spot_lights,
                          SpotLightDescription{vec(position), vec(direction), vec(intensity), cutoff, beam});
          },
          "position"_a, "direction"_a, "intensity"_a, "cutoff_degrees"_a, "beam_degrees"_a)
      .def(
          "project",
          [](D& d, std::uint32_t spot, std::uint32_t texture, const Triple& u_axis, const Triple& v_axis) {
            if (spot >= d.spot_lights.size()) throw py::value_error("no such spot light");
            SpotLightDescription& s = d.spot_lights[spot];
            s.texture = texture, s.u_axis = vec(u_axis), s.v_axis = vec(v_axis);
          },
          "spot"_a, "texture"_a, py::kw_only(), "u_axis"_a, "v_axis"_a)
      .def(
          "add_directional_light",
          [](D& d, const Triple& direction, const Triple& irradiance) {
            return append(d.directional_lights, DirectionalLightDescription{vec(direction), vec(irradiance)});
          },
          "direction"_a, "irradiance"_a)
      .def(
          "add_constant_environment",
          [](D& d, const Triple& radiance) { d.environment = ConstantEnvironmentDescription{vec(radiance)}; },
          "radiance"_a)
      .def(
          "add_image_environment",
          [](D& d, const ArrayF& pixels, double scale, const ArrayD& t) {
            d.environment = image_environment(pixels, scale, t);
          },
          "pixels"_a, "scale"_a, "to_world"_a);
}

void bind_builder(py::module_& m) {
  Builder builder(m, "SceneBuilder", "A scene in world space, float64, in the units of its author.");
  builder.def(py::init<>());
  bind_models(m, builder);
  bind_textures(builder);
  bind_sensors(builder);
  bind_motion(builder);
  bind_shapes(builder);
  bind_surfaces(builder);
  bind_groups(builder);
  bind_lights(builder);
  builder.def(
      "build",
      [](D& d, const std::string& intersection) {
        if (intersection != "robust" && intersection != "fast")
          throw py::value_error("intersection is \"robust\" or \"fast\", not \"" + intersection + "\"");
        const auto mode = intersection == "robust" ? Intersection::robust : Intersection::fast;
        SceneDescription description = std::exchange(d, {});
        const py::gil_scoped_release release;
        return std::make_shared<Scene>(build_checked_scene(std::move(description), {.intersection = mode}));
      },
      "intersection"_a = "robust", "Compile what was added; the builder is empty afterwards.");
}

}  // namespace

Transform transform(const ArrayD& a) {
  if (a.ndim() != 2 || a.shape(0) != 4 || a.shape(1) != 4) throw py::value_error("a transform is a 4x4 matrix");
  Transform t;
  std::copy_n(a.data(), 16, t.m[0].data());
  return t;
}

void bind_scene(py::module_& m) {
  bind_builder(m);
  py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene", "A compiled scene: immutable.")
      .def("effects", [](const Scene& s) { return effects_dict(derive_effects(s)); })
      .def_property_readonly("shapes", [](const Scene& s) { return s.geometry.surfaces.size(); })
      .def_property_readonly("triangles", [](const Scene& s) { return s.geometry.triangle_count(); })
      .def_property_readonly("instances", [](const Scene& s) { return s.geometry.instances.size(); })
      .def_property_readonly("dropped_triangles", [](const Scene& s) { return s.geometry.dropped_triangles; })
      .def_property_readonly("lights", [](const Scene& s) { return s.lights.size(); })
      .def_property_readonly("memory_bytes", &Scene::memory_bytes)
      .def_property_readonly(
          "film_shape", [](const Scene& s) { return std::pair(s.camera.film.crop_height, s.camera.film.crop_width); })
      .def("intersect", &nearest_hits, "origins"_a, "directions"_a, "time"_a = 0.5F, "only"_a = py::none(),
           "threads"_a = 1, "What rays meet first, one array each by its name, of those in `only` if it is given.");
}

}  // namespace equaltime
