#include "equaltime/build/part_names.h"

namespace equaltime {

namespace {

std::string name(const char* part, std::size_t number, const char* kind) {
  return std::string(part) + " " + std::to_string(number) + " (" + kind + ")";
}

}  // namespace

std::string bsdf_name(const SceneDescription& description, std::size_t index) {
  const BsdfDescription& bsdf = description.bsdfs[index];
  const char* kind = std::holds_alternative<NullDescription>(bsdf) ? "null" : "mixture";
  Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
    if (std::holds_alternative<typename Model::Description>(bsdf)) kind = Model::name;
  });
  return name("BSDF", index, kind);
}

std::string shape_name(const std::vector<ShapeDescription>& shapes, std::size_t index) {
  return name("shape", index, ShapeDescriptions::names[shapes[index].index()]);
}

std::string shape_name(const SceneDescription& description, std::size_t group, std::size_t index) {
  return "group " + std::to_string(group) + ": " + shape_name(description.groups[group].shapes, index);
}

std::string numbered_shape_name(const SceneDescription& description, std::size_t number) {
  if (number < description.shapes.size()) return shape_name(description.shapes, number);
  std::size_t index = number - description.shapes.size(), group = 0;
  while (index >= description.groups[group].shapes.size()) index -= description.groups[group++].shapes.size();
  return shape_name(description, group, index);
}

}  // namespace equaltime
