// What moves, for SceneBuilder.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using ArrayD = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Keys at (K,) times, from 0, when the shutter opens, to 1, with (K, 4, 4) matrices.
std::vector<MotionKey> keys(const ArrayD& times, const ArrayD& matrices) {
  if (times.ndim() != 1 || times.size() == 0 || matrices.ndim() != 3 || matrices.shape(0) != times.shape(0) ||
      matrices.shape(1) != 4 || matrices.shape(2) != 4)
    throw py::value_error("keys are one 4x4 matrix for each time, and one at least");
  std::vector<MotionKey> keys(static_cast<std::size_t>(times.size()));
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].time = times.data()[i];
    std::copy_n(matrices.data() + 16 * i, 16, keys[i].to_world.m[0].data());
  }
  return keys;
}

/// Points (T, N, 3) at T times after the first.
std::vector<std::vector<Vec3d>> later(const ArrayD& points) {
  if (points.ndim() != 3 || points.shape(2) != 3)
    throw py::value_error("points at later times have the shape (T, N, 3)");
  std::vector<std::vector<Vec3d>> steps(static_cast<std::size_t>(points.shape(0)));
  const auto count = static_cast<std::size_t>(points.shape(1));
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (std::size_t k = 0; k < count; ++k) {
      const double* p = points.data() + 3 * (i * count + k);
      steps[i].push_back({p[0], p[1], p[2]});
    }
  return steps;
}

}  // namespace

void bind_motion(py::class_<SceneDescription>& builder) {
  using D = SceneDescription;
  builder
      .def(
          "add_moving_instance",
          [](D& d, std::uint32_t group, const ArrayD& times, const ArrayD& matrices) {
            d.shapes.emplace_back(InstanceDescription{group, {}, keys(times, matrices)});
            return d.shapes.size() - 1;
          },
          "group"_a, "times"_a, "matrices"_a)
      .def(
          "deform_mesh",
          [](D& d, std::uint32_t shape, const ArrayD& vertices, const std::optional<ArrayD>& normals) {
            auto* mesh = shape < d.shapes.size() ? std::get_if<MeshDescription>(&d.shapes[shape]) : nullptr;
            if (mesh == nullptr) throw py::value_error("only a mesh can be deformed");
            mesh->later_vertices = later(vertices);
            if (normals) mesh->later_normals = later(*normals);
          },
          "shape"_a, "vertices"_a, "normals"_a = py::none())
      .def(
          "move_sensor",
          [](D& d, const ArrayD& times, const ArrayD& matrices) { d.sensor_keys = keys(times, matrices); }, "times"_a,
          "matrices"_a);
}

}  // namespace equaltime
