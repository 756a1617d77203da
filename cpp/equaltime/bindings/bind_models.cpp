// The BSDFs and media of a SceneBuilder, by the fields of their models' descriptions, and what models there are.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "equaltime/base/fields.h"
#include "equaltime/bindings/bindings.h"
#include "equaltime/media/phase_function.h"

namespace py = pybind11;
using namespace pybind11::literals;

namespace equaltime {

namespace {

void read(py::handle given, double& value) { value = given.cast<double>(); }
void read(py::handle given, bool& value) { value = given.cast<bool>(); }
void read(py::handle given, std::vector<double>& value) { value = given.cast<std::vector<double>>(); }
/// A single number is a grey.
void read(py::handle given, Vec3d& value) {
  if (PyNumber_Check(given.ptr()) && !PySequence_Check(given.ptr())) {
    const auto grey = given.cast<double>();
    value = {grey, grey, grey};
    return;
  }
  const auto [r, g, b] = given.cast<std::array<double, 3>>();
  value = {r, g, b};
}
void read(py::handle given, MicrofacetModel& value) {
  const auto name = given.cast<std::string>();
  if (name == "ggx")
    value = MicrofacetModel::ggx;
  else if (name == "beckmann")
    value = MicrofacetModel::beckmann;
  else
    throw py::value_error("a distribution is \"ggx\" or \"beckmann\", not \"" + name + "\"");
}

/// A description by values in the order of its fields, by names, or both; what is not given stays as it is by itself.
template <class Model>
typename Model::Description described(const py::args& values, const py::dict& named) {
  typename Model::Description d{};
  std::size_t used = 0;
  for_each_of(Model::fields(), [&](const auto& field, std::size_t i) {
    const bool by_place = i < values.size(), by_name = named.contains(field.name);
    if (by_place && by_name) throw py::type_error(std::string(Model::name) + ": " + field.name + " is given twice");
    if (!by_place && !by_name) return;
    const py::object given = by_place ? py::object(values[i]) : py::object(named[field.name]);
    try {
      read(given, d.*field.value);
    } catch (const py::cast_error&) {
      throw py::type_error(std::string(Model::name) + ": cannot use " + field.name + " = " +
                           py::repr(given).cast<std::string>());
    }
    ++used;
  });
  if (used == values.size() + named.size()) return d;
  std::string known;
  for_each_of(Model::fields(),
              [&](const auto& field, std::size_t i) { known += (i > 0 ? ", " : "") + std::string(field.name); });
  throw py::type_error(std::string(Model::name) + ": the parameters are " + known);
}

std::uint32_t add_bsdf(SceneDescription& d, const std::string& type, const py::args& values, const py::kwargs& named) {
  const std::size_t before = d.bsdfs.size();
  Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
    if (type == Model::name) d.bsdfs.emplace_back(described<Model>(values, named));
  });
  if (d.bsdfs.size() == before) throw py::value_error("no BSDF \"" + type + '"');
  return static_cast<std::uint32_t>(before);
}

/// A phase function's lobe: its weight, the name of its law, and the law's parameters.
using Lobe = std::tuple<double, std::string, py::dict>;

std::uint32_t add_medium(SceneDescription& d, const Vec3d& sigma_t, const Vec3d& albedo,
                         const std::vector<Lobe>& phase) {
  MediumDescription medium{sigma_t, albedo};
  for (const auto& lobe : phase) {
    const std::size_t before = medium.phase.size();
    PhaseLobes::for_each([&]<class Model>(std::type_identity<Model>) {
      if (std::get<1>(lobe) == Model::name)
        medium.phase.push_back({described<Model>({}, std::get<2>(lobe)), std::get<0>(lobe)});
    });
    if (medium.phase.size() == before) throw py::value_error("no phase function \"" + std::get<1>(lobe) + '"');
  }
  d.media.push_back(std::move(medium));
  return static_cast<std::uint32_t>(d.media.size() - 1);
}

template <class Table>
py::list names_in(const Table& table) {
  py::list names;
  for_each_of(table, [&](const auto& entry, std::size_t) { names.append(entry.name); });
  return names;
}

const char* effect_of(bool Effects::*needs) {
  for (const auto& [value, name] : kEffectFields)
    if (value == needs) return name;
  throw std::logic_error("an effect without a name");
}

/// Returns by type what the core knows of a BSDF: its parameters, in the order of add_bsdf, those that textures may
/// give, and the effect that it needs, or None.
py::dict bsdf_models() {
  py::dict models;
  Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
    py::object effect = py::none();
    if constexpr (requires { Model::needs; }) effect = py::str(effect_of(Model::needs));
    models[Model::name] = py::dict("parameters"_a = names_in(Model::fields()),
                                   "textured"_a = names_in(Model::textured()), "effect"_a = effect);
  });
  return models;
}

/// Returns the effect of each phase function, by name. All of them need media besides.
py::dict phase_functions() {
  py::dict phases;
  PhaseFunctions::for_each(
      [&]<class Model>(std::type_identity<Model>) { phases[Model::name] = effect_of(Model::needs); });
  return phases;
}

}  // namespace

void bind_models(py::module_& m, py::class_<SceneDescription>& builder) {
  m.def("bsdf_models", &bsdf_models);
  m.def("phase_functions", &phase_functions);
  builder.def("add_bsdf", &add_bsdf, "type"_a, "Add a one-sided BSDF of its parameters; returns its index.")
      .def(
          "add_medium",
          [](SceneDescription& d, const std::array<double, 3>& sigma_t, const std::array<double, 3>& albedo,
             const std::vector<Lobe>& phase) {
            return add_medium(d, {sigma_t[0], sigma_t[1], sigma_t[2]}, {albedo[0], albedo[1], albedo[2]}, phase);
          },
          "sigma_t"_a, "albedo"_a, "phase"_a = std::vector<Lobe>(),
          "Add a medium; returns its index. Its phase function is a sum of laws, each of a weight, a name and "
          "parameters; isotropic without any.");
}

}  // namespace equaltime
