// What a SceneBuilder makes of BSDFs: mixtures, and textures of their parameters; bitmaps are NumPy arrays in the
// precision that they keep.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstring>

#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using ArrayD = py::array_t<double, py::array::c_style | py::array::forcecast>;
using ArrayF = py::array_t<float, py::array::c_style | py::array::forcecast>;

UvTransform uv_transform(const std::optional<ArrayD>& a) {
  UvTransform t = kSameUv;
  if (!a) return t;
  if (a->ndim() != 2 || a->shape(0) != 2 || a->shape(1) != 3) throw py::value_error("to_uv is a 2x3 matrix");
  std::copy_n(a->data(), 6, t.data());
  return t;
}

TexelFormat format(const py::array& texels) {
  if (texels.dtype().is(py::dtype("uint8"))) return TexelFormat::u8;
  if (texels.dtype().is(py::dtype("float16"))) return TexelFormat::half;
  if (texels.dtype().is(py::dtype("float32"))) return TexelFormat::float32;
  throw py::value_error("texels are uint8, float16 or float32");
}

TextureFilter filter(const std::string& name) {
  if (name == "nearest") return TextureFilter::nearest;
  if (name == "bilinear") return TextureFilter::bilinear;
  throw py::value_error("a texture's filter is \"nearest\" or \"bilinear\", not \"" + name + "\"");
}

TextureWrap wrap(const std::string& name) {
  if (name == "repeat") return TextureWrap::repeat;
  if (name == "mirror") return TextureWrap::mirror;
  if (name == "clamp") return TextureWrap::clamp;
  throw py::value_error("a texture wraps by \"repeat\", \"mirror\" or \"clamp\", not \"" + name + "\"");
}

std::uint32_t add_bitmap(SceneDescription& d, const py::array& given, bool srgb, const std::string& filter_name,
                         const std::string& wrap_name, const std::optional<ArrayD>& to_uv) {
  const py::array texels = py::array::ensure(given, py::array::c_style);
  if (texels.ndim() != 3) throw py::value_error("texels have the shape (H, W, 1) or (H, W, 3)");
  BitmapDescription bitmap;
  bitmap.height = static_cast<std::uint32_t>(texels.shape(0));
  bitmap.width = static_cast<std::uint32_t>(texels.shape(1));
  bitmap.channels = static_cast<std::uint32_t>(texels.shape(2));
  bitmap.format = format(texels);
  bitmap.texels.resize(static_cast<std::size_t>(texels.nbytes()));
  std::memcpy(bitmap.texels.data(), texels.data(), bitmap.texels.size());
  bitmap.srgb = srgb;
  bitmap.filter = filter(filter_name);
  bitmap.wrap = wrap(wrap_name);
  bitmap.to_uv = uv_transform(to_uv);
  d.textures.emplace_back(std::move(bitmap));
  return static_cast<std::uint32_t>(d.textures.size() - 1);
}

std::uint32_t add_checkerboard(SceneDescription& d, std::array<double, 3> color0, std::array<double, 3> color1,
                               const std::optional<ArrayD>& to_uv) {
  d.textures.emplace_back(CheckerboardDescription{
      {color0[0], color0[1], color0[2]}, {color1[0], color1[1], color1[2]}, uv_transform(to_uv)});
  return static_cast<std::uint32_t>(d.textures.size() - 1);
}

void set_attribute(SceneDescription& d, std::uint32_t shape, std::uint32_t texture, const ArrayF& values,
                   bool per_face) {
  if (values.ndim() != 2) throw py::value_error("the values of an attribute have the shape (N, 1) or (N, 3)");
  auto* mesh = shape < d.shapes.size() ? std::get_if<MeshDescription>(&d.shapes[shape]) : nullptr;
  if (mesh == nullptr) throw py::value_error("only meshes have attributes");
  mesh->attributes.push_back({texture, static_cast<std::uint32_t>(values.shape(1)), per_face,
                              std::vector<float>(values.data(), values.data() + values.size())});
}

std::uint32_t add_mixture(SceneDescription& d, std::uint32_t first, std::uint32_t second, double weight,
                          std::optional<double> cutoff) {
  if (!(weight >= 0 && weight <= 1)) throw py::value_error("the weight of a mixture lies in [0, 1]");
  if (cutoff && !(*cutoff >= 0)) throw py::value_error("the cutoff of a mixture is at least 0");
  d.bsdfs.emplace_back(MixtureDescription{first, second, weight, cutoff});
  return static_cast<std::uint32_t>(d.bsdfs.size() - 1);
}

}  // namespace

void bind_textures(py::class_<SceneDescription>& builder) {
  builder
      .def("add_bitmap", &add_bitmap, "texels"_a, py::kw_only(), "srgb"_a, "filter"_a = "bilinear", "wrap"_a = "repeat",
           "to_uv"_a = py::none())
      .def("add_checkerboard", &add_checkerboard, "color0"_a, "color1"_a, py::kw_only(), "to_uv"_a = py::none())
      .def("add_mesh_attribute",
           [](SceneDescription& d) {
             d.textures.emplace_back(MeshAttributeDescription{});
             return d.textures.size() - 1;
           })
      .def("set_attribute", &set_attribute, "shape"_a, "texture"_a, "values"_a, py::kw_only(), "per_face"_a)
      .def(
          "bend",
          [](SceneDescription& d, std::uint32_t bsdf, std::uint32_t texture, bool bump, double scale, bool flip_invalid,
             bool shadowing, bool turned) {
            d.normal_maps.push_back({bsdf, texture, bump, scale, flip_invalid, shadowing, turned});
          },
          "bsdf"_a, "texture"_a, py::kw_only(), "bump"_a, "scale"_a = 1.0, "flip_invalid"_a = true,
          "shadowing"_a = true, "turned"_a = false)
      .def("add_null",
           [](SceneDescription& d) {
             d.bsdfs.emplace_back(NullDescription{});
             return d.bsdfs.size() - 1;
           })
      .def("add_mixture", &add_mixture, "first"_a, "second"_a, "weight"_a, "cutoff"_a = py::none())
      .def(
          "bind",
          [](SceneDescription& d, std::uint32_t bsdf, const std::string& name, std::uint32_t texture,
             std::optional<std::uint32_t> times) {
            d.bindings.push_back({bsdf, name, texture, times});
          },
          "bsdf"_a, "parameter"_a, "texture"_a, "times"_a = py::none());
}

}  // namespace equaltime
