// The Python module equaltime._core: one function a noun, declarations only. Each level of x86-64 has a file with it.
#include <pybind11/pybind11.h>

#include "equaltime/bindings/bindings.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "The C++ core of equaltime. Use it through the package's public functions.";
  equaltime::bind_film(m);
  equaltime::bind_bench(m);
  equaltime::bind_meshes(m);
  equaltime::bind_scene(m);
  equaltime::bind_render(m);
  equaltime::bind_replay(m);
  equaltime::bind_sampling(m);
  equaltime::bind_breakdown(m);
}
