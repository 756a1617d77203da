// What each bind_*.cpp adds to the module.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "equaltime/build/description.h"

namespace equaltime {

void bind_bench(pybind11::module_& m);      // the limit ratio
void bind_film(pybind11::module_& m);       // moments and what is made of them
void bind_meshes(pybind11::module_& m);     // mesh files
void bind_scene(pybind11::module_& m);      // SceneBuilder, Scene
void bind_render(pybind11::module_& m);     // Settings, Renderer, build information
void bind_replay(pybind11::module_& m);     // one sample, vertex by vertex
void bind_sampling(pybind11::module_& m);   // samplers and densities, for tests
void bind_breakdown(pybind11::module_& m);  // where light comes from
void bind_models(pybind11::module_& m, pybind11::class_<SceneDescription>& builder);  // BSDFs and media
void bind_sensors(pybind11::class_<SceneDescription>& builder);
void bind_textures(pybind11::class_<SceneDescription>& builder);
void bind_motion(pybind11::class_<SceneDescription>& builder);

/// A poll that lets Python handle signals and goes on; called with the GIL released. Throws what a handler raises.
inline bool check_signals() {
  const pybind11::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  return true;
}

/// Throws ValueError for what is no 4x4 matrix.
[[nodiscard]] Transform transform(
    const pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>& a);

}  // namespace equaltime
