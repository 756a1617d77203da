// Sensors and films as plain data, in world space, in the units of their author.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "equaltime/math/transform.h"

namespace equaltime {

/// Camera space looks along +z, +x to the left of the image, +y up.
struct PerspectiveDescription {
  Transform to_world = {};  // keeps lengths
  double x_fov_degrees = 50;
  std::optional<double> near = {}, far = {};  // planes across the axis; geometry outside is not seen
  double principal_point_x = 0, principal_point_y = 0;
};
/// A perspective whose lens is a disk, or as many blades as are given leave a regular polygon of it: only what is at
/// focus_distance along the axis is sharp. A radius of 0 makes it a pinhole.
struct ThinLensDescription {
  PerspectiveDescription view = {};
  double aperture_radius = 0, focus_distance = 1;  // radius: of the polygon's corners, too
  std::uint32_t blades = 0;                        // none, or 3 at the least
  double rotation_degrees = 0;                     // of a corner, from the camera's +x to its +y
};
/// Parallel rays along the camera's +z from the plane of its origin: the film's width is [-1, 1] of its x axis.
struct OrthographicDescription {
  Transform to_world = {};                    // may scale: that is how its size is said
  std::optional<double> near = {}, far = {};  // in camera space
};
/// All directions from one point: the film's width is once round the camera's y axis, its height from +y to -y; its
/// middle looks along +z.
struct SphericalDescription {
  Transform to_world = {};                    // keeps lengths
  std::optional<double> near = {}, far = {};  // distances from the camera
};
using SensorDescription =
    std::variant<PerspectiveDescription, ThinLensDescription, OrthographicDescription, SphericalDescription>;
enum class FilterKind : std::uint8_t { box, tent, gaussian, mitchell, lanczos };
struct FilmDescription {
  std::uint32_t width = 256, height = 256;
  std::uint32_t crop_x = 0, crop_y = 0, crop_width = 256, crop_height = 256;
  FilterKind filter = FilterKind::box;
  // box, tent: radius; gaussian: standard deviation, cut at four of them; mitchell: B and C; lanczos: radius
  double filter_parameter = 0.5, second_filter_parameter = 0;
};

/// Where the sensor stands and looks.
[[nodiscard]] inline const Transform& placement(const SensorDescription& sensor) noexcept {
  if (const auto* lens = std::get_if<ThinLensDescription>(&sensor)) return lens->view.to_world;
  if (const auto* parallel = std::get_if<OrthographicDescription>(&sensor)) return parallel->to_world;
  if (const auto* spherical = std::get_if<SphericalDescription>(&sensor)) return spherical->to_world;
  return std::get_if<PerspectiveDescription>(&sensor)->to_world;
}

inline void place(SensorDescription& sensor, const Transform& to_world) noexcept {
  if (auto* lens = std::get_if<ThinLensDescription>(&sensor))
    lens->view.to_world = to_world;
  else
    std::visit(
        [&](auto& any) {
          if constexpr (requires { any.to_world; }) any.to_world = to_world;
        },
        sensor);
}

}  // namespace equaltime
