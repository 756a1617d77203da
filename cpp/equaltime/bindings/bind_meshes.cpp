// Mesh readers for Python. The arrays own the buffers that the readers filled: nothing is copied, and they are
// read-only.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "equaltime/bindings/bindings.h"
#include "equaltime/io/obj.h"
#include "equaltime/io/ply.h"

namespace py = pybind11;

namespace equaltime {
namespace {

template <typename T>
py::array rows(std::vector<T>&& values, py::ssize_t width) {
  auto owned = std::make_unique<std::vector<T>>(std::move(values));
  const auto count = static_cast<py::ssize_t>(owned->size()) / width;
  T* const first = owned->data();
  const py::capsule owner(owned.get(), [](void* held) { delete static_cast<std::vector<T>*>(held); });
  (void)owned.release();  // the capsule deletes it from here on
  py::array_t<T> array({count, width}, first, owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

// A word of a file that is quoted may be no UTF-8.
py::str text(std::string_view bytes) {
  const auto size = static_cast<py::ssize_t>(bytes.size());
  return py::reinterpret_steal<py::str>(PyUnicode_DecodeUTF8(bytes.data(), size, "replace"));
}
py::list texts(const std::vector<std::string>& lines) {
  py::list out;
  for (const std::string& line : lines) out.append(text(line));
  return out;
}

struct MeshArrays {
  explicit MeshArrays(MeshData&& mesh)
      : vertices(rows(std::move(mesh.vertices), 3)),
        faces(rows(std::move(mesh.faces), 3)),
        normals(mesh.normals.empty() ? py::object(py::none()) : rows(std::move(mesh.normals), 3)),
        uvs(mesh.uvs.empty() ? py::object(py::none()) : rows(std::move(mesh.uvs), 2)),
        warnings(texts(mesh.warnings)) {
    for (MeshAttributeData& a : mesh.attributes) {
      attributes[text(a.name)] = rows(std::move(a.values), static_cast<py::ssize_t>(a.width));
      full[text(a.name)] = a.full;
    }
    for (const NamedFile& file : mesh.files) files.append(py::make_tuple(py::bytes(file.name), file.line));
  }

  py::object vertices, faces, normals, uvs;
  py::dict attributes, full;
  py::list files;
  py::list warnings;
};

template <class T>
std::vector<T> copied(const py::array_t<T, py::array::c_style | py::array::forcecast>& array, py::ssize_t width) {
  if (array.ndim() != 2 || array.shape(1) != width)
    throw py::value_error("an array of a mesh has the shape (N, " + std::to_string(width) + ")");
  return std::vector<T>(array.data(), array.data() + array.size());
}

using Reals = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Indices = py::array_t<std::uint32_t, py::array::c_style | py::array::forcecast>;

/// Arrays that another reader has filled, brought to what MeshData promises.
MeshArrays finished(const std::filesystem::path& path, const Reals& vertices, const Indices& faces,
                    const std::optional<Reals>& normals, const std::optional<Reals>& uvs,
                    const std::map<std::string, Reals>& vertex_attributes, std::vector<std::string> warnings) {
  MeshData mesh;
  mesh.warnings = std::move(warnings);
  mesh.vertices = copied(vertices, 3);
  mesh.faces = copied(faces, 3);
  if (normals) mesh.normals = copied(*normals, 3);
  if (uvs) mesh.uvs = copied(*uvs, 2);
  const std::size_t count = mesh.vertices.size() / 3;
  if ((normals && mesh.normals.size() != 3 * count) || (uvs && mesh.uvs.size() != 2 * count))
    throw py::value_error("a mesh has as many normals and uvs as vertices, or none");
  for (const auto& [name, values] : vertex_attributes) {
    const py::ssize_t width = values.ndim() == 2 ? values.shape(1) : 0;
    if (width < 1 || values.shape(0) != static_cast<py::ssize_t>(count))
      throw py::value_error("a mesh has as many values of an attribute as vertices");
    mesh.attributes.push_back({name, static_cast<std::size_t>(width), false, copied(values, width), 1});
  }
  for (const std::uint32_t i : mesh.faces)
    if (i >= count) throw py::value_error("a face names a vertex that does not exist");
  {
    const py::gil_scoped_release release;
    finish_mesh(mesh, path, 0, [&](std::uint32_t i) { return path.string() + ": vertex " + std::to_string(i); });
  }
  return MeshArrays(std::move(mesh));
}

template <class Read>
MeshArrays without_lock(Read&& read) {
  return MeshArrays([&] {
    const py::gil_scoped_release release;
    return read();
  }());
}

}  // namespace

void bind_meshes(py::module_& m) {
  static py::handle mesh_error = py::exception<MeshError>(m, "MeshError", PyExc_ValueError).release();
  mesh_error.attr("__doc__") = "A mesh file cannot be read; the text begins with its path and line or byte offset.";
  // pybind11 fixes the signature.
  py::register_exception_translator([](std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param)
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const MeshError& error) {
      // A path or a name of the file may be no UTF-8; that must not hide the error.
      PyErr_SetObject(mesh_error.ptr(), text(error.what()).ptr());
    }
  });

  py::class_<MeshArrays>(m, "MeshData",
                         "A triangle mesh as its file gives it, in the file's space and units; read-only.")
      .def_readonly("vertices", &MeshArrays::vertices, "(N, 3) float64, every one finite and used by a face")
      .def_readonly("faces", &MeshArrays::faces, "(M, 3) uint32, in range, none degenerate")
      .def_readonly("normals", &MeshArrays::normals, "(N, 3) float64 as in the file, not normalised, or None")
      .def_readonly("uvs", &MeshArrays::uvs, "(N, 2) float64 or None")
      .def_readonly("attributes", &MeshArrays::attributes,
                    "By Mitsuba's names: vertex_... (N, 1 or 3) and face_... (M, 1 or 3) float64")
      .def_readonly("full", &MeshArrays::full, "By the same names: what stands for 1, such as 255 for bytes")
      .def_readonly(
          "files", &MeshArrays::files,
          "Libraries of materials of an OBJ file, images of a PLY file: their names in bytes, and their lines")
      .def_readonly("warnings", &MeshArrays::warnings,
                    "What was repaired, dropped or is not used, counted; without the path");
  m.def(
      "finished_mesh", &finished, py::arg("path"), py::arg("vertices"), py::arg("faces"), py::arg("normals"),
      py::arg("uvs"), py::arg("vertex_attributes") = py::dict(), py::arg("warnings") = std::vector<std::string>(),
      "Bring arrays of another reader to the promises of MeshData; `path` is for messages, and `warnings` are what the "
      "reader has to tell. Raises MeshError.");
  m.def(
      "read_ply", [](const std::filesystem::path& path) { return without_lock([&] { return read_ply(path); }); },
      py::arg("path"), "Read a PLY file, ascii or binary. Raises MeshError.");
  m.def(
      "read_obj",
      [](const std::filesystem::path& path, const std::optional<std::string>& material) {
        return without_lock([&] { return read_obj(path, material); });
      },
      py::arg("path"), py::arg("material") = py::none(),
      "Read a Wavefront OBJ file, or only the faces of one material (\"\": of none). Raises MeshError.");
  m.def(
      "read_obj_by_material",
      [](const std::filesystem::path& path) {
        auto materials = [&] {
          const py::gil_scoped_release release;
          return read_obj_by_material(path);
        }();
        py::dict arrays;
        for (auto& [name, mesh] : materials) arrays[py::bytes(name)] = MeshArrays(std::move(mesh));
        return arrays;
      },
      py::arg("path"),
      "Read a Wavefront OBJ file once: the meshes of all materials that have faces, by their names in bytes, in the "
      "order of their first faces. Raises MeshError.");
  m.def(
      "obj_name", [](const std::string& rest) { return py::bytes(std::string(obj_name(rest))); }, py::arg("rest"),
      "The name in the rest of a statement such as usemtl or newmtl, in bytes: without blanks and comment.");
}

}  // namespace equaltime
