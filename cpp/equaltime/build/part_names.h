// Names of a description's parts for errors: kind and number, such as "BSDF 3 (rough plastic)". Part of build_scene.
#pragma once

#include <cstddef>
#include <string>

#include "equaltime/build/description.h"

namespace equaltime {

/// A BSDF by its index in the description, such as "BSDF 3 (rough plastic)".
[[nodiscard]] std::string bsdf_name(const SceneDescription& description, std::size_t index);
/// A shape by its index in a list, such as "shape 3 (sphere)".
[[nodiscard]] std::string shape_name(const std::vector<ShapeDescription>& shapes, std::size_t index);
/// A shape of a group, such as "group 0: shape 3 (sphere)".
[[nodiscard]] std::string shape_name(const SceneDescription& description, std::size_t group, std::size_t index);
/// A shape by its number in the scene: the shapes of groups are counted after all others, group by group.
[[nodiscard]] std::string numbered_shape_name(const SceneDescription& description, std::size_t number);

}  // namespace equaltime
