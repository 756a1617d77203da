// How the light tree is made: top down, by the surface area and orientation heuristic over bins of centres
// (Conty Estevez & Kulla 2018, section 4.1), and by halves where that would make it too deep.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "equaltime/lights/light_tree.h"
#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

namespace {

constexpr int kMaxDepth = 63;  // as many steps as a trail of 64 bits tells, and still tells from none
constexpr std::size_t kBins = 12;
/// Of any light that shines at all.
constexpr float kLeastIntensity = std::numeric_limits<float>::min();
constexpr double kWorst = std::numeric_limits<double>::infinity();

double coordinate(const Vec3d& v, int axis) noexcept { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

/// What a cluster costs by chance: intensity, extent and orientation. The extent is that of a sphere around its box,
/// which is what importance sees; unlike the box's area it is 0 for a single point only.
double cost(const LightBounds& cluster) noexcept {
  return cluster.intensity * length_squared(cluster.box.extent()) * orientation_measure(cluster.normals);
}

/// Equal slices of a box along one axis; a light belongs to that of its centre.
struct Bins {
  Bins(const Bounds& centers, int along, std::size_t lights) noexcept
      : axis(along),
        count(std::min(kBins, lights)),
        lo(coordinate(centers.lo, along)),
        extent(coordinate(centers.extent(), along)) {}

  [[nodiscard]] std::size_t of(const LightBounds& light) const noexcept {
    const double place = (coordinate(light.box.center(), axis) - lo) / extent;
    return std::min(static_cast<std::size_t>(place * static_cast<double>(count)), count - 1);
  }

  int axis;
  std::size_t count;
  double lo, extent;
};

}  // namespace

class LightTreeBuilder {
 public:
  LightTreeBuilder(LightTree& tree, std::span<const LightBounds> lights) : tree_(tree) {
    tree_.trails_.assign(lights.size(), LightTree::kNoTrail);
    for (std::uint32_t i = 0; i < lights.size(); ++i)
      if (lights[i].intensity > 0) leaves_.push_back({lights[i], i, 1});
    if (leaves_.empty()) return;
    tree_.first_ = leaves_[0].index;
    tree_.nodes_.reserve(leaves_.size() - 1);
    (void)build(leaves_, 0, 0);
  }

 private:
  /// A cluster and where it is found: a node, or a light where count is 1.
  struct Child {
    LightBounds bounds;
    std::uint32_t index, count;
  };
  using Range = std::span<Child>;

  Child build(Range leaves, std::uint64_t trail, int depth) {
    if (leaves.size() == 1) {
      tree_.trails_[leaves[0].index] = trail;
      tree_.depth_ = std::max(tree_.depth_, depth);
      return leaves[0];
    }
    const auto index = static_cast<std::uint32_t>(tree_.nodes_.size());
    tree_.nodes_.emplace_back();
    const std::size_t middle = split(leaves, kMaxDepth - depth);
    const Child left = build(leaves.first(middle), trail, depth + 1);
    const Child right = build(leaves.subspan(middle), trail | (std::uint64_t{1} << depth), depth + 1);
    fill(tree_.nodes_[index], 0, left);
    fill(tree_.nodes_[index], 1, right);
    return {join(left.bounds, right.bounds), index, left.count + right.count};
  }

  /// Orders the lights by child and returns how many are the left one's.
  static std::size_t split(Range leaves, int levels_left) noexcept {
    if (leaves.size() == 2) return 1;
    Bounds centers;
    for (const Child& leaf : leaves) centers.include(leaf.bounds.box.center());
    // Halves need as many levels as the count has bits: a split by cost must leave so many below it.
    if (static_cast<int>(std::bit_width(leaves.size())) < levels_left)
      if (const std::size_t middle = split_by_cost(leaves, centers)) return middle;
    const std::size_t middle = leaves.size() / 2;
    const Vec3d extent = centers.extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    std::nth_element(leaves.begin(), leaves.begin() + static_cast<std::ptrdiff_t>(middle), leaves.end(),
                     [axis](const Child& a, const Child& b) { return before(a, b, axis); });
    return middle;
  }

  static bool before(const Child& a, const Child& b, int axis) noexcept {
    const double ca = coordinate(a.bounds.box.center(), axis), cb = coordinate(b.bounds.box.center(), axis);
    return ca != cb ? ca < cb : a.index < b.index;
  }

  /// 0 if the lights have one centre: there is nothing to choose.
  static std::size_t split_by_cost(Range leaves, const Bounds& centers) noexcept {
    const double longest = max_component(centers.extent());
    double least = kWorst;
    std::optional<Bins> best;
    std::size_t best_edge = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = coordinate(centers.extent(), axis);
      if (!(extent > 0)) continue;
      const Bins bins(centers, axis, leaves.size());
      const auto [edge, total] = cheapest_edge(leaves, bins);
      // Thin boxes are not to be cut thinner (the paper's regularisation).
      if (best && !(total * (longest / extent) < least)) continue;
      least = total * (longest / extent), best = bins, best_edge = edge;
    }
    if (!best) return 0;
    const auto right =
        std::partition(leaves.begin(), leaves.end(), [&](const Child& c) { return best->of(c.bounds) < best_edge; });
    return static_cast<std::size_t>(right - leaves.begin());
  }

  struct Edge {
    std::size_t first_right;  // bin
    double total;
  };
  /// The edge between bins, with lights on both sides, whose two clusters cost least.
  static Edge cheapest_edge(Range leaves, const Bins& bins) noexcept {
    std::array<std::optional<LightBounds>, kBins> content;
    const auto add = [](std::optional<LightBounds>& to, const LightBounds& more) { to = to ? join(*to, more) : more; };
    for (const Child& leaf : leaves) add(content[bins.of(leaf.bounds)], leaf.bounds);
    std::array<double, kBins> right_cost{};
    std::optional<LightBounds> right, left;
    for (std::size_t i = bins.count; i-- > 1;) {
      if (content[i]) add(right, *content[i]);
      right_cost[i] = right ? cost(*right) : kWorst;
    }
    Edge best{1, kWorst};
    for (std::size_t i = 1; i < bins.count; ++i) {
      if (content[i - 1]) add(left, *content[i - 1]);
      const double total = cost(*left) + right_cost[i];  // the first bin is never empty, nor is the last
      if (total < best.total) best = {i, total};
    }
    return best;
  }

  static void fill(LightTree::Node& node, std::size_t side, const Child& child) noexcept {
    const LightBounds& b = child.bounds;
    const Vec3f center(b.box.center()), axis(b.normals.axis);
    node.x[side] = center.x, node.y[side] = center.y, node.z[side] = center.z;
    node.axis_x[side] = axis.x, node.axis_y[side] = axis.y, node.axis_z[side] = axis.z;
    // Points of lights are rounded to float32 as the centre is: the sphere holds the rounded ones too.
    const double rounding =
        0x1p-20 * b.radius + 0x1p-22 * (max_component(abs(b.box.lo)) + max_component(abs(b.box.hi)));
    node.radius[side] = static_cast<float>(b.radius + rounding);
    const auto [sine, cosine] = elementary::sin_cos(b.normals.spread);
    node.cos_spread[side] = static_cast<float>(cosine), node.sin_spread[side] = static_cast<float>(sine);
    node.intensity[side] = std::max(static_cast<float>(b.intensity), kLeastIntensity);
    node.index[side] = child.index, node.count[side] = child.count;
  }

  LightTree& tree_;
  std::vector<Child> leaves_;
};

LightTree::LightTree(std::span<const LightBounds> lights) { LightTreeBuilder(*this, lights); }

}  // namespace equaltime
