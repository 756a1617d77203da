#include "equaltime/math/box_tree.h"

#include <algorithm>
#include <numeric>

namespace equaltime {

BoxTree::BoxTree(const std::vector<Bounds>& boxes) {
  if (boxes.empty()) return;
  std::vector<std::uint32_t> numbers(boxes.size());
  std::iota(numbers.begin(), numbers.end(), 0U);
  nodes_.reserve(2 * boxes.size() - 1);
  add(boxes, numbers.data(), numbers.data() + numbers.size());
}

void BoxTree::add(const std::vector<Bounds>& boxes, std::uint32_t* first, std::uint32_t* last) {
  Bounds box, centers;
  for (const std::uint32_t* i = first; i != last; ++i) {
    box.include(boxes[*i]);
    centers.include(boxes[*i].center());
  }
  const std::size_t own = nodes_.size();
  const bool leaf = last - first == 1;
  nodes_.push_back({box, leaf ? *first : kInner, 0});
  if (!leaf) {
    const Vec3d e = centers.extent();
    const auto coordinate = e.x >= e.y && e.x >= e.z ? &Vec3d::x : e.y >= e.z ? &Vec3d::y : &Vec3d::z;
    std::uint32_t* middle = first + (last - first) / 2;
    std::nth_element(first, middle, last, [&](std::uint32_t a, std::uint32_t b) {
      return boxes[a].center().*coordinate < boxes[b].center().*coordinate;
    });
    add(boxes, first, middle);
    add(boxes, middle, last);
  }
  nodes_[own].next = static_cast<std::uint32_t>(nodes_.size());
}

}  // namespace equaltime
