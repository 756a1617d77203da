// The BSDFs of a SceneBuilder: one-sided leaves by their parameters; each returns the index of what was added.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "equaltime/bindings/bindings.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

using Triple = std::array<double, 3>;
using D = SceneDescription;

Vec3d vec(const Triple& t) { return {t[0], t[1], t[2]}; }

std::uint32_t append(D& d, BsdfDescription&& bsdf) {
  d.bsdfs.push_back(std::move(bsdf));
  return static_cast<std::uint32_t>(d.bsdfs.size() - 1);
}

MicrofacetModel microfacet(const std::string& name) {
  if (name == "ggx") return MicrofacetModel::ggx;
  if (name == "beckmann") return MicrofacetModel::beckmann;
  throw py::value_error("a distribution is \"ggx\" or \"beckmann\", not \"" + name + "\"");
}

}  // namespace

void bind_bsdfs(py::class_<SceneDescription>& builder) {
  builder
      .def(
          "add_diffuse", [](D& d, const Triple& r) { return append(d, DiffuseDescription{vec(r)}); }, "reflectance"_a)
      .def(
          "add_conductor",
          [](D& d, const Triple& eta, const Triple& k, const Triple& r) {
            return append(d, ConductorDescription{vec(eta), vec(k), vec(r)});
          },
          "eta"_a, "k"_a, "specular_reflectance"_a)
      .def(
          "add_rough_conductor",
          [](D& d, const std::string& distribution, double alpha_u, double alpha_v, const Triple& eta, const Triple& k,
             const Triple& r) {
            return append(
                d, RoughConductorDescription{microfacet(distribution), alpha_u, alpha_v, vec(eta), vec(k), vec(r)});
          },
          "distribution"_a, "alpha_u"_a, "alpha_v"_a, "eta"_a, "k"_a, "specular_reflectance"_a)
      .def(
          "add_dielectric",
          [](D& d, double ior, const Triple& r, const Triple& t) {
            return append(d, DielectricDescription{ior, vec(r), vec(t)});
          },
          "ior"_a, "specular_reflectance"_a, "specular_transmittance"_a)
      .def(
          "add_thin_dielectric",
          [](D& d, double ior, const Triple& r, const Triple& t) {
            return append(d, ThinDielectricDescription{ior, vec(r), vec(t)});
          },
          "ior"_a, "specular_reflectance"_a, "specular_transmittance"_a)
      .def(
          "add_rough_dielectric",
          [](D& d, const std::string& distribution, double alpha_u, double alpha_v, double ior, const Triple& r,
             const Triple& t) {
            return append(
                d, RoughDielectricDescription{microfacet(distribution), alpha_u, alpha_v, {ior, vec(r), vec(t)}});
          },
          "distribution"_a, "alpha_u"_a, "alpha_v"_a, "ior"_a, "specular_reflectance"_a, "specular_transmittance"_a)
      .def(
          "add_plastic",
          [](D& d, double ior, const Triple& diffuse, const Triple& specular, bool nonlinear) {
            return append(d, PlasticDescription{ior, vec(diffuse), vec(specular), nonlinear});
          },
          "ior"_a, "diffuse_reflectance"_a, "specular_reflectance"_a, "nonlinear"_a)
      .def(
          "add_principled",
          [](D& d, const Triple& base_color, double roughness, double anisotropic, double metallic, double spec_trans,
             double ior, double spec_tint, double sheen, double sheen_tint, double flatness, double clearcoat,
             double clearcoat_gloss) {
            return append(d, PrincipledDescription{vec(base_color), roughness, anisotropic, metallic, spec_trans, ior,
                                                   spec_tint, sheen, sheen_tint, flatness, clearcoat, clearcoat_gloss});
          },
          "base_color"_a, py::kw_only(), "roughness"_a, "anisotropic"_a, "metallic"_a, "spec_trans"_a, "ior"_a,
          "spec_tint"_a, "sheen"_a, "sheen_tint"_a, "flatness"_a, "clearcoat"_a, "clearcoat_gloss"_a)
      .def(
          "add_rough_plastic",
          [](D& d, const std::string& distribution, double alpha, double ior, const Triple& diffuse,
             const Triple& specular, bool nonlinear) {
            return append(d, RoughPlasticDescription{
                                 microfacet(distribution), alpha, {ior, vec(diffuse), vec(specular), nonlinear}});
          },
          "distribution"_a, "alpha"_a, "ior"_a, "diffuse_reflectance"_a, "specular_reflectance"_a, "nonlinear"_a);
}

}  // namespace equaltime
