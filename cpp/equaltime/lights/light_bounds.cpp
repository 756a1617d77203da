#include "equaltime/lights/light_bounds.h"

#include <algorithm>
#include <cmath>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {
constexpr double kPiD = std::numbers::pi;
}

NormalCone join(const NormalCone& a, const NormalCone& b) noexcept {
  const NormalCone &wide = a.spread < b.spread ? b : a, &narrow = a.spread < b.spread ? a : b;
  if (wide.spread >= kPiD) return wide;
  const double cosine = dot(wide.axis, narrow.axis);
  const double between = elementary::acos(std::clamp(cosine, -1.0, 1.0));
  if (between + narrow.spread <= wide.spread) return wide;
  const double spread = 0.5 * (wide.spread + between + narrow.spread);
  const Vec3d across = narrow.axis - wide.axis * cosine;
  const double norm = length(across);
  if (!(norm > 0) && cosine > 0) return wide;
  if (!(norm > 0) || !(spread < kPiD)) return {};
  const auto [sine, turned] = elementary::sin_cos(spread - wide.spread);
  return {normalize(wide.axis * turned + across * (sine / norm)), spread};
}

double orientation_measure(const NormalCone& cone) noexcept {
  const auto [sine, cosine] = elementary::sin_cos(cone.spread);
  // θw of the equation is put in: spread + 90°, or else 180°.
  if (cone.spread < 0.5 * kPiD) return kPiD * (2 - cosine + 0.5 * kPiD * sine);
  return kPiD * (2 * (1 - cosine) + (kPiD - cone.spread) * sine);
}

LightBounds join(const LightBounds& a, const LightBounds& b) noexcept {
  LightBounds both{a.box, 0, join(a.normals, b.normals), a.intensity + b.intensity};
  both.box.include(b.box);
  const Vec3d center = both.box.center();
  const double reach = std::max(length(center - a.box.center()) + a.radius, length(center - b.box.center()) + b.radius);
  both.radius = std::min(0.5 * length(both.box.extent()), reach);
  return both;
}

}  // namespace equaltime
