// LightTree: one of many lights, picked in proportion to a bound of what it may send to a receiver (Conty Estevez &
// Kulla 2018, without splitting). A binary tree over clusters of lights; a pick walks down it, so that its cost grows
// with the logarithm of their number. Never gives probability 0 to a light that the receiver may see.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "equaltime/base/optional.h"
#include "equaltime/lights/light_bounds.h"
#include "equaltime/lights/light_types.h"

namespace equaltime {

class LightTree {
 public:
  /// Places at the leaves' disposal: a light's probability is a whole number of them, at least one if its clusters may
  /// be seen. Probabilities are so the exact ones of the choice, and sum to 1 exactly.
  static constexpr int kUnitBits = 62;
  static constexpr std::int64_t kUnits = std::int64_t{1} << kUnitBits;

  LightTree() = default;
  /// Lights keep their index; those of intensity 0 are never picked.
  explicit LightTree(std::span<const LightBounds> lights);

  [[nodiscard]] bool empty() const noexcept { return first_ == kNoLight; }
  /// Whether any light may reach the receiver. If not, nothing can be picked; if so, nothing may be picked all the
  /// same, because smaller clusters are bounded more tightly.
  [[nodiscard]] bool may_light(const LightSampleContext& receiver) const noexcept;
  /// `place` is one of [0, kUnits), all equally likely.
  [[nodiscard]] Optional<PickedLight> pick(const LightSampleContext& receiver, std::int64_t place) const noexcept;
  /// Probability with which `pick` gives the light, to the last bit.
  [[nodiscard]] float pmf(const LightSampleContext& receiver, std::uint32_t light) const noexcept;
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return nodes_.size() * sizeof(Node) + trails_.size() * sizeof(trails_[0]);
  }
  /// Most steps from the root to a light.
  [[nodiscard]] int depth() const noexcept { return depth_; }

 private:
  friend class LightTreeBuilder;
  static constexpr std::uint32_t kNoLight = ~std::uint32_t{0};
  static constexpr std::uint64_t kNoTrail = ~std::uint64_t{0};

  /// An inner node: what it knows of its two children, in arrays so that both are looked at together.
  struct alignas(32) Node {
    std::array<float, 2> x, y, z, radius;         // of a sphere that holds the child's lights
    std::array<float, 2> axis_x, axis_y, axis_z;  // of the cone that holds their normals
    std::array<float, 2> cos_spread, sin_spread;  // of its half angle
    std::array<float, 2> intensity;               // see LightBounds
    std::array<std::uint32_t, 2> index;           // of a node, or of a light where count is 1
    std::array<std::uint32_t, 2> count;           // lights below
  };
  [[nodiscard]] static std::array<double, 2> importance(const Node& node, const LightSampleContext& receiver) noexcept;
  [[nodiscard]] static std::int64_t left_places(const Node& node, const LightSampleContext& receiver,
                                                std::int64_t places) noexcept;

  std::vector<Node> nodes_;
  std::vector<std::uint64_t> trails_;  // of each light: bit d says which child to take at depth d
  std::uint32_t first_ = kNoLight;     // some light; the only one if there are no nodes
  int depth_ = 0;
};

}  // namespace equaltime
