// The camera and its film, as the builder is told of them.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using ArrayD = py::array_t<double, py::array::c_style | py::array::forcecast>;

FilterKind filter(const std::string& name) {
  if (name == "box") return FilterKind::box;
  if (name == "tent") return FilterKind::tent;
  if (name == "gaussian") return FilterKind::gaussian;
  if (name == "mitchell") return FilterKind::mitchell;
  if (name == "lanczos") return FilterKind::lanczos;
  throw py::value_error("a filter is \"box\", \"tent\", \"gaussian\", \"mitchell\" or \"lanczos\", not \"" + name +
                        "\"");
}

}  // namespace

void bind_sensors(py::class_<SceneDescription>& builder) {
  using D = SceneDescription;
  builder
      .def(
          "set_perspective",
          [](D& d, const ArrayD& t, double x_fov, std::optional<double> near, std::optional<double> far,
             std::array<double, 2> offset, double aperture_radius, double focus_distance, std::uint32_t blades,
             double rotation) {
            const PerspectiveDescription view{transform(t), x_fov, near, far, offset[0], offset[1]};
            d.sensor = ThinLensDescription{view, aperture_radius, focus_distance, blades, rotation};
          },
          "to_world"_a, "x_fov_degrees"_a, "near"_a = py::none(), "far"_a = py::none(),
          "principal_point_offset"_a = std::array<double, 2>{0, 0}, "aperture_radius"_a = 0.0, "focus_distance"_a = 1.0,
          "blades"_a = 0, "rotation_degrees"_a = 0.0)
      .def(
          "set_orthographic",
          [](D& d, const ArrayD& t, std::optional<double> near, std::optional<double> far) {
            d.sensor = OrthographicDescription{transform(t), near, far};
          },
          "to_world"_a, "near"_a = py::none(), "far"_a = py::none())
      .def(
          "set_spherical",
          [](D& d, const ArrayD& t, std::optional<double> near, std::optional<double> far) {
            d.sensor = SphericalDescription{transform(t), near, far};
          },
          "to_world"_a, "near"_a = py::none(), "far"_a = py::none())
      .def(
          "set_film",
          [](D& d, std::uint32_t width, std::uint32_t height, std::array<std::uint32_t, 4> crop,
             const std::string& name, double parameter, double second) {
            d.film = {width, height, crop[0], crop[1], crop[2], crop[3], filter(name), parameter, second};
          },
          "width"_a, "height"_a, "crop"_a, "filter"_a, "parameter"_a, "second"_a = 0.0);
}

}  // namespace equaltime
