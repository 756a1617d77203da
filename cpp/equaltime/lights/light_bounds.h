// LightBounds: where one light or many are, where their normals point, and how brightly they shine, in float64.
// All lights are taken to emit within 90° of their normals (θe of Conty Estevez & Kulla 2018). Normalised space.
#pragma once

#include <numbers>

#include "equaltime/math/bounds.h"

namespace equaltime {

/// All directions within an angle of an axis.
struct NormalCone {
  Vec3d axis{0, 0, 1};               // unit
  double spread = std::numbers::pi;  // half the opening angle, 0 to π
};

/// The narrowest cone around both whose axis is between theirs; all directions if the axes are opposite.
[[nodiscard]] NormalCone join(const NormalCone& a, const NormalCone& b) noexcept;

/// ∫ of the cosine to the nearest direction of the cone, where it is positive (Conty Estevez & Kulla 2018, eq. 1, in
/// closed form): π for a single direction, 4π for all.
[[nodiscard]] double orientation_measure(const NormalCone& cone) noexcept;

struct LightBounds {
  Bounds box;
  double radius = 0;  // of a sphere around the box's centre that holds the lights
  NormalCone normals;
  double intensity = 0;  // the sum of each light's largest radiant intensity; 0 for one that never shines
};

[[nodiscard]] LightBounds join(const LightBounds& a, const LightBounds& b) noexcept;

}  // namespace equaltime
