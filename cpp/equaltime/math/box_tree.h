// BoxTree: finds, among many boxes, those that touch one, in a time that grows with what it finds. Each node is split
// in half across the longest side of its boxes' centres.
#pragma once

#include <cstdint>
#include <vector>

#include "equaltime/math/bounds.h"

namespace equaltime {

class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(const std::vector<Bounds>& boxes);

  /// Calls f with the number of each box that touches this one, until f returns false.
  template <class F>
  void each_touching(const Bounds& box, F&& f) const {
    for (std::size_t i = 0; i < nodes_.size();) {
      const Node& node = nodes_[i];
      if (!touch(node.box, box)) {
        i = node.next;
        continue;
      }
      if (node.number != kInner && !f(node.number)) return;
      ++i;
    }
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept { return nodes_.size() * sizeof(Node); }

 private:
  static constexpr std::uint32_t kInner = ~std::uint32_t{0};

  struct Node {
    Bounds box;
    std::uint32_t number;  // of the box that a leaf holds
    std::uint32_t next;    // the node after all those below this one
  };

  void add(const std::vector<Bounds>& boxes, std::uint32_t* first, std::uint32_t* last);

  std::vector<Node> nodes_;  // each before those below it
};

}  // namespace equaltime
