#include "equaltime/lights/light_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "equaltime/math/numeric.h"

namespace equaltime {

namespace {

/// Four numbers worked on together: the two children as lights, then as what the receiver faces.
using Lanes = float __attribute__((vector_size(16)));

Lanes twice(const std::array<float, 2>& children) noexcept {
  return Lanes{children[0], children[1], children[0], children[1]};
}
Lanes side_by_side(const std::array<float, 2>& lights, float receiver) noexcept {
  return Lanes{lights[0], lights[1], receiver, receiver};
}
Lanes square_root(Lanes v) noexcept {
  return Lanes{std::sqrt(v[0]), std::sqrt(v[1]), std::sqrt(v[2]), std::sqrt(v[3])};
}
Lanes positive(Lanes v) noexcept { return v > 0 ? v : Lanes{}; }

/// Added to cosines, so that their rounding (below 3e-3, where a sine near 0 comes from a cosine near 1) hides no
/// light.
constexpr float kSlack = 0x1p-8F;
/// Nearer than this, distances in normalised space are rounding.
constexpr float kNearestSquared = 0x1p-74F;
/// Part of all random numbers that no child is given: none.
constexpr std::int64_t kDark = -1;

float probability(std::int64_t places) noexcept {
  return static_cast<float>(places) / static_cast<float>(LightTree::kUnits);
}

}  // namespace

/// Intensity times bounds of the cosines at light and receiver, over a bound of the squared distance (eq. 3 of the
/// paper), both times the same number: instead of dividing by its own squared distance, each is multiplied by the
/// other's, in float64, where nothing over- or underflows. 0 only if no light of the child can reach the receiver.
EQUALTIME_INLINE std::array<double, 2> LightTree::importance(const Node& node,
                                                             const LightSampleContext& receiver) noexcept {
  const Lanes dx = receiver.p.x - twice(node.x), dy = receiver.p.y - twice(node.y), dz = receiver.p.z - twice(node.z);
  const Lanes distance_squared = dx * dx + dy * dy + dz * dz;
  const Lanes radius = twice(node.radius), radius_squared = radius * radius;
  // Within a cluster anything is possible; so it is where it is too far for the square to be finite.
  const auto outside = (distance_squared > radius_squared) & (distance_squared < kInfinity);
  const Lanes one{1, 1, 1, 1};
  const Lanes inverse = one / square_root(outside ? distance_squared : one);
  const Lanes along = side_by_side(node.axis_x, -receiver.n.x) * dx + side_by_side(node.axis_y, -receiver.n.y) * dy +
                      side_by_side(node.axis_z, -receiver.n.z) * dz;
  // Angles: w between axis or normal and the centre, less the cone's spread, less u, which the sphere subtends.
  // A cosine beyond 1 stands for no angle at all.
  const float no_bound = receiver.opaque ? 0.0F : 2.0F;
  const Lanes cos_w = along * inverse + Lanes{0, 0, no_bound, no_bound};
  const Lanes sin_w = square_root(positive(1 - cos_w * cos_w));
  const Lanes cos_o = side_by_side(node.cos_spread, 1), sin_o = side_by_side(node.sin_spread, 0);
  const auto within_cone = cos_w > cos_o;
  const Lanes cos_x = within_cone ? one : cos_w * cos_o + sin_w * sin_o;
  const Lanes sin_x = within_cone ? Lanes{} : sin_w * cos_o - cos_w * sin_o;
  const Lanes sin_u = radius * inverse;
  const Lanes cos_u = square_root(positive(1 - sin_u * sin_u));
  const Lanes nearest = cos_x > cos_u ? one : cos_x * cos_u + sin_x * sin_u;
  const Lanes cosine = positive((outside ? nearest : one) + kSlack);
  const Lanes reach = distance_squared > radius_squared ? distance_squared : radius_squared;
  const auto weight = [&](std::size_t child) noexcept {
    const float over = std::clamp(reach[1 - child], kNearestSquared, std::numeric_limits<float>::max());
    return static_cast<double>(node.intensity[child]) * cosine[child] * cosine[child + 2] * over;
  };
  return {weight(0), weight(1)};
}

/// How many of a node's places its left child gets: in proportion to importance, but one a light at least if there is
/// any. The smaller share is rounded, and the larger one gets the rest: neither loses digits.
EQUALTIME_INLINE std::int64_t LightTree::left_places(const Node& node, const LightSampleContext& receiver,
                                                     std::int64_t places) noexcept {
  const auto [left, right] = importance(node, receiver);
  if (!(left > 0)) return right > 0 ? 0 : kDark;
  if (!(right > 0)) return places;
  const bool left_is_less = left < right;
  const double share = std::min(left, right) / (left + right);
  const std::int64_t least = node.count[left_is_less ? 0 : 1], rest = node.count[left_is_less ? 1 : 0];
  const auto proportional = static_cast<std::int64_t>(static_cast<double>(places) * share);
  const std::int64_t smaller = std::min(std::max(proportional, least), places - rest);
  return left_is_less ? smaller : places - smaller;
}

bool LightTree::may_light(const LightSampleContext& receiver) const noexcept {
  if (nodes_.empty()) return !empty();
  const auto [left, right] = importance(nodes_[0], receiver);
  return left > 0 || right > 0;
}

Optional<PickedLight> LightTree::pick(const LightSampleContext& receiver, std::int64_t place) const noexcept {
  if (empty()) return std::nullopt;
  if (nodes_.empty()) return PickedLight{first_, 1};
  std::int64_t places = kUnits;
  std::uint32_t index = 0;
  for (;;) {
    const Node& node = nodes_[index];
    const std::int64_t left = left_places(node, receiver, places);
    if (left == kDark) return std::nullopt;
    if (place < left) {
      places = left;
      index = node.index[0];
      if (node.count[0] == 1) break;
    } else {
      place -= left, places -= left;
      index = node.index[1];
      if (node.count[1] == 1) break;
    }
  }
  return PickedLight{index, probability(places)};
}

float LightTree::pmf(const LightSampleContext& receiver, std::uint32_t light) const noexcept {
  std::uint64_t trail = trails_[light];
  if (trail == kNoTrail) return 0;
  if (nodes_.empty()) return 1;
  std::int64_t places = kUnits;
  for (std::uint32_t index = 0;; trail >>= 1) {
    const Node& node = nodes_[index];
    const std::int64_t left = left_places(node, receiver, places);
    const bool is_right = (trail & 1) != 0;
    places = is_right ? places - left : left;
    if (left == kDark || places == 0) return 0;
    index = node.index[is_right];
    if (node.count[is_right] == 1) return probability(places);
  }
}

}  // namespace equaltime
