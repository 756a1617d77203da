#include "scene/coincident_lamps.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "scene/build_meshes.h"
#include "scene/surface.h"

namespace equaltime {

namespace {

/// How far a lamp is moved beyond what its own and the surface's rounding need: what float32 leaves of the length of a
/// ray across the scene, which is up to 2^11 long.
constexpr double kClearance = 16 * static_cast<double>(kUnitRoundoff) * 0x1p11;
/// Corners of the polygon round a disk.
constexpr int kDiskCorners = 24;
/// Pairs of coincident lamps, for each lamp on average, that a scene may have: more are no scene that is meant, and
/// take time that grows with their square.
constexpr std::size_t kMostPairs = 64;

using Polygon = std::vector<Vec3d>;

/// A triangle in normalised space. Its winding gives the normal, and a lamp emits to that side.
struct Face {
  std::array<Vec3d, 3> v;
  Vec3d n;
  double doubt;  // how far float32 and Embree may see it from its plane
  std::size_t shape, number;

  [[nodiscard]] Bounds bounds() const noexcept {
    Bounds b;
    for (const Vec3d& p : v) b.include(p - Vec3d{doubt, doubt, doubt}), b.include(p + Vec3d{doubt, doubt, doubt});
    return b;
  }
};

bool overlap(const Bounds& a, const Bounds& b) noexcept {
  return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z &&
         b.lo.z <= a.hi.z;
}

/// Calls f with every triangle of a shape: its corners, and its number.
template <class F>
void for_each_triangle(const MeshDescription& mesh, F&& f) {
  if (!mesh.later_vertices.empty()) return;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    if (std::max({a, b, c}) < mesh.vertices.size()) f(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], i);
  }
}
/// Calls `f` with each triangle of a convex polygon around the origin of a plane. Its front is that of `d`.
template <class Flat, class F>
void for_each_triangle(const Flat& d, std::span<const std::array<double, 2>> corners, F&& f) {
  const auto at = [&](std::size_t i) { return d.to_world.point({corners[i][0], corners[i][1], 0}); };
  const double handedness = dot(cross(d.to_world.column(0), d.to_world.column(1)), d.to_world.column(2));
  const bool flipped = d.flip_normals != (handedness < 0);
  for (std::size_t i = 1; i + 1 < corners.size(); ++i)
    f(at(0), at(flipped ? i + 1 : i), at(flipped ? i : i + 1), i - 1);
}
template <class F>
void for_each_triangle(const RectangleDescription& r, F&& f) {
  constexpr std::array<std::array<double, 2>, 4> kSquare = {{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for_each_triangle(r, kSquare, f);
}
template <class F>
void for_each_triangle(const DiskDescription& d, F&& f) {
  std::array<std::array<double, 2>, kDiskCorners> corners;
  for (int i = 0; i < kDiskCorners; ++i) {
    const double turn = 2 * std::numbers::pi / kDiskCorners, reach = 1 / std::cos(0.5 * turn);
    corners[static_cast<std::size_t>(i)] = {reach * std::cos(i * turn), reach * std::sin(i * turn)};
  }
  for_each_triangle(d, corners, f);
}

/// Returns the part of the polygon on which a linear function is not negative.
Polygon clipped(const Polygon& polygon, const Vec3d& gradient, double offset) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double hp = dot(gradient, p) - offset, hq = dot(gradient, q) - offset;
    if (hp >= 0) kept.push_back(p);
    if ((hp < 0) != (hq < 0)) kept.push_back(p + (q - p) * (hp / (hp - hq)));
  }
  return kept;
}

/// The part of a face that is before or behind the other, as seen along the other's normal.
Polygon common(const Face& face, const Face& other) {
  Polygon polygon(face.v.begin(), face.v.end());
  for (std::size_t i = 0; i < 3 && !polygon.empty(); ++i) {
    const Vec3d inward = cross(other.n, other.v[(i + 1) % 3] - other.v[i]);
    polygon = clipped(polygon, inward, dot(inward, other.v[i]));
  }
  return polygon;
}

double area(const Polygon& polygon) noexcept {
  Vec3d sum;
  for (std::size_t i = 2; i < polygon.size(); ++i) sum += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  return 0.5 * length(sum);
}

/// How high a face reaches above the lamp's plane, if the two are one within rounding where they overlap.
std::optional<double> coincidence(const Face& lamp, const Face& face) {
  const double near = 4 * (lamp.doubt + face.doubt);
  const Polygon shared = common(face, lamp);
  const double sides = length(lamp.v[1] - lamp.v[0]) + length(lamp.v[2] - lamp.v[0]);
  if (shared.size() < 3 || !(area(shared) > near * sides)) return std::nullopt;
  double highest = -near;
  for (const Vec3d& p : shared) {
    const double h = dot(lamp.n, p - lamp.v[0]);
    if (std::abs(h) > near) return std::nullopt;
    highest = std::max(highest, h);
  }
  return highest + near + kClearance;
}

/// The faces of lamps, in a tree of boxes: each node holds a range, halved at the middle of its longest side.
class LampTree {
 public:
  explicit LampTree(std::vector<Face>& faces) : faces_(faces) { build(0, faces.size()); }
  /// Calls f with the number of every face whose box overlaps.
  template <class F>
  void find(const Bounds& box, F&& f) const {
    find(0, 0, faces_.size(), box, f);
  }

 private:
  static constexpr std::size_t kLeaf = 4;

  std::size_t build(std::size_t begin, std::size_t end) {
    const std::size_t node = boxes_.size();
    boxes_.emplace_back(), second_.push_back(0);
    for (std::size_t i = begin; i < end; ++i) boxes_[node].include(faces_[i].bounds());
    if (end - begin <= kLeaf) return node;
    const Vec3d size = boxes_[node].extent();
    double Vec3d::*const axis = size.x >= size.y && size.x >= size.z ? &Vec3d::x
                                : size.y >= size.z                   ? &Vec3d::y
                                                                     : &Vec3d::z;
    const std::size_t middle = (begin + end) / 2;
    const auto at = [&](std::size_t i) { return faces_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](const Face& a, const Face& b) {
      return a.bounds().center().*axis < b.bounds().center().*axis;
    });
    build(begin, middle);
    second_[node] = build(middle, end);
    return node;
  }
  template <class F>
  void find(std::size_t node, std::size_t begin, std::size_t end, const Bounds& box, F& f) const {
    if (!overlap(boxes_[node], box)) return;
    if (second_[node] == 0) {
      for (std::size_t i = begin; i < end; ++i) f(i);
      return;
    }
    find(node + 1, begin, (begin + end) / 2, box, f);
    find(second_[node], (begin + end) / 2, end, box, f);
  }

  std::vector<Face>& faces_;
  std::vector<Bounds> boxes_;
  std::vector<std::size_t> second_;  // the second child of each node; 0: it has none
};

[[nodiscard]] bool shines(const SurfaceDescription& s) noexcept { return s.radiance && max_component(*s.radiance) > 0; }

/// Whether a shape of the scene emits by its own surface.
bool is_lamp(const ShapeDescription& shape) noexcept {
  return std::visit(
      [](const auto& s) {
        if constexpr (requires { s.surface; }) return shines(s.surface);
        return false;
      },
      shape);
}

/// Whether triangles stand for a kind of shape.
template <class S>
concept Flat = requires(const S& s) {
  for_each_triangle(s, [](auto&&...) {});
};

/// Flat lamps.
class FlatLamps {
 public:
  FlatLamps(SceneDescription& description, const Normalization& space)
      : description_(description), space_(space), lamps_(collected()), lifts_(lamps_.size(), 0) {}

  void bring_forward() {
    if (lamps_.empty()) return;
    const LampTree tree(lamps_);
    for (std::size_t shape = 0; shape < description_.shapes.size(); ++shape) compare_all(tree, shape);
    raise_above_lamps();
    for (std::size_t i = 0; i < lamps_.size(); ++i)
      if (lifts_[i] > 0) lift(lamps_[i], lifts_[i]);
  }

 private:
  using Number = std::pair<std::size_t, std::size_t>;  // of a shape, and of a face of it
  /// One lamp before another that emits to the same side.
  struct Above {
    std::size_t lamp;
    Number below;
    double by;
  };

  [[nodiscard]] std::optional<Face> face(const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t shape,
                                         std::size_t number) const {
    const std::array<Vec3d, 3> v = {space_.point(a), space_.point(b), space_.point(c)};
    const Vec3d normal = cross(v[1] - v[0], v[2] - v[0]);
    const double size = length(normal);
    if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
    const auto doubt = static_cast<double>(triangle_plane(Vec3f(v[0]), Vec3f(v[1]), Vec3f(v[2])).offset);
    if (!std::isfinite(doubt)) return std::nullopt;  // no area is left in float32
    return Face{v, normal / size, doubt, shape, number};
  }

  [[nodiscard]] std::vector<Face> collected() const {
    std::vector<Face> lamps;
    const auto collect = [&]<class S>(const S& s, std::size_t shape) {
      if constexpr (Flat<S>)
        if (shines(s.surface))
          for_each_triangle(s, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t number) {
            if (const auto lamp = face(a, b, c, shape, number)) lamps.push_back(*lamp);
          });
    };
    for (std::size_t i = 0; i < description_.shapes.size(); ++i)
      std::visit([&](const auto& s) { collect(s, i); }, description_.shapes[i]);
    return lamps;
  }

  /// Compares what stands still of a shape with the lamps. An instance is rounded once more.
  void compare_all(const LampTree& tree, std::size_t shape) {
    const auto look_at = [&]<class S>(const S& s, const Transform& placed, double roundings) {
      if constexpr (Flat<S>)
        for_each_triangle(s, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t number) {
          auto other = face(placed.point(a), placed.point(b), placed.point(c), shape, number);
          if (!other) return;
          other->doubt *= roundings;
          tree.find(other->bounds(), [&](std::size_t lamp) { compare(lamp, *other); });
        });
    };
    const ShapeDescription& described = description_.shapes[shape];
    const auto* instance = std::get_if<InstanceDescription>(&described);
    if (instance == nullptr) return std::visit([&](const auto& s) { look_at(s, Transform(), 1); }, described);
    if (instance->group >= description_.groups.size() || !instance->keys.empty()) return;
    for (const ShapeDescription& part : description_.groups[instance->group].shapes)
      std::visit([&](const auto& s) { look_at(s, instance->to_world, 4); }, part);
  }

  void compare(std::size_t number, const Face& other) {
    const Face& lamp = lamps_[number];
    if (lamp.shape == other.shape && lamp.number == other.number) return;
    const auto by = coincidence(lamp, other);
    if (!by) return;
    if (lamp.shape == other.shape)
      fail(lamp.shape, "its triangles " + std::to_string(other.number) + " and " + std::to_string(lamp.number) +
                           " emit from one place: leave one of them out, or make them two shapes");
    const bool emits = is_lamp(description_.shapes[other.shape]);
    if (emits && ++pairs_ > kMostPairs * lamps_.size())
      fail(lamp.shape, "too many lamps lie in one place: leave all but one of them out");
    if (!emits || dot(lamp.n, other.n) < 0)
      lifts_[number] = std::max(lifts_[number], *by);
    else if (other.shape < lamp.shape)
      above_.push_back({number, {other.shape, other.number}, *by});
  }

  void raise_above_lamps() {
    std::map<Number, std::size_t> numbers;
    for (std::size_t i = 0; !above_.empty() && i < lamps_.size(); ++i) numbers[{lamps_[i].shape, lamps_[i].number}] = i;
    std::ranges::sort(above_, {}, [&](const Above& a) { return lamps_[a.lamp].shape; });
    for (const auto& [lamp, below, by] : above_) lifts_[lamp] = std::max(lifts_[lamp], lifts_[numbers.at(below)] + by);
  }

  /// Moves the shape of a face so that the face is as high above its place as it shall be, or higher.
  void lift(const Face& lamp, double by) {
    std::vector<Vec3d>& moved = moved_[lamp.shape];
    ShapeDescription& shape = description_.shapes[lamp.shape];
    auto* mesh = std::get_if<MeshDescription>(&shape);
    moved.resize(mesh != nullptr ? mesh->vertices.size() : 1);
    const auto move = [&](std::size_t i) {
      const Vec3d step = lamp.n * std::max(0.0, by - dot(lamp.n, moved[i]));
      moved[i] += step;
      return step * space_.world_length(1);
    };
    if (mesh != nullptr)
      for (const std::uint32_t i : mesh->triangles[lamp.number]) mesh->vertices[i] += move(i);
    else if (auto* rectangle = std::get_if<RectangleDescription>(&shape))
      translate(rectangle->to_world, move(0));
    else if (auto* disk = std::get_if<DiskDescription>(&shape))
      translate(disk->to_world, move(0));
  }
  static void translate(Transform& t, const Vec3d& by) noexcept {
    t.m[0][3] += by.x, t.m[1][3] += by.y, t.m[2][3] += by.z;
  }

  SceneDescription& description_;
  const Normalization& space_;
  std::vector<Face> lamps_;
  std::vector<double> lifts_;  // of each, in normalised space
  std::vector<Above> above_;
  std::size_t pairs_ = 0;                            // of lamps
  std::map<std::size_t, std::vector<Vec3d>> moved_;  // of a shape or, of a mesh, of its vertices
};

/// How far apart surfaces of two shapes of one kind are anywhere, at most, or infinite if they are two surfaces.
double apart(const SphereDescription& a, const SphereDescription& b) noexcept {
  return length(a.center - b.center) + std::abs(a.radius - b.radius);
}
double apart(const CylinderDescription& a, const CylinderDescription& b) noexcept {
  const Vec3d axis = normalize(b.end - b.base);
  const auto off = [&](const Vec3d& p) { return length(cross(axis, p - b.base)); };
  const double from = dot(axis, a.base - b.base), to = dot(axis, a.end - b.base);
  const bool beside = std::max(from, to) <= 0 || std::min(from, to) >= length(b.end - b.base);
  return beside ? HUGE_VAL : std::max(off(a.base), off(a.end)) + std::abs(a.radius - b.radius);
}
/// A point that surfaces have in common that are one.
Vec3d place(const SphereDescription& s) noexcept { return s.center; }
Vec3d place(const CylinderDescription& c) noexcept {
  const Vec3d axis = normalize(c.end - c.base);
  return c.base - axis * dot(axis, c.base);
}
/// How far from the origin of the space a shape reaches along each axis.
Vec3d reach(const SphereDescription& s, const Normalization& space) noexcept { return abs(space.point(s.center)); }
Vec3d reach(const CylinderDescription& c, const Normalization& space) noexcept {
  return max(abs(space.point(c.base)), abs(space.point(c.end)));
}

/// Lamps that are spheres, or cylinders: their radius changes. Those that are one lie next to each other along a
/// direction across which no grid is likely to be aligned.
template <class Round>
class RoundLamps {
 public:
  RoundLamps(SceneDescription& description, const Normalization& space) : space_(space) {
    for (ShapeDescription& shape : description.shapes)
      if (auto* round = std::get_if<Round>(&shape)) all_.push_back(round);
    for (std::size_t i = 0; i < all_.size(); ++i) {
      along_.emplace_back(key(*all_[i]), i);
      near_ = std::max(near_, near(*all_[i]));
    }
    std::ranges::sort(along_);
  }

  void bring_forward() {
    std::vector<double> lifts;
    for (std::size_t i = 0; i < all_.size(); ++i) lifts.push_back(shines(all_[i]->surface) ? lift(i) : 0);
    for (std::size_t i = 0; i < all_.size(); ++i)
      all_[i]->radius += space_.world_length(all_[i]->flip_normals ? -lifts[i] : lifts[i]);
  }

 private:
  static constexpr Vec3d kDirection{1, 0.61803398874989485, 0.41421356237309505};

  [[nodiscard]] double key(const Round& s) const noexcept { return space_.length(dot(kDirection, place(s))); }
  [[nodiscard]] double near(const Round& s) const noexcept {
    const double radius = space_.length(s.radius);
    const Vec3d far = reach(s, space_) + Vec3d{radius, radius, radius};
    return 8 * static_cast<double>(point_offset(Vec3f(far), {1, 1, 1}));
  }
  /// Before all that are one with a lamp, unless they come later and emit to the same side.
  [[nodiscard]] double lift(std::size_t number) const noexcept {
    const Round& lamp = *all_[number];
    double sum = 0;
    const double width = near_ * length(kDirection);
    auto at = std::ranges::lower_bound(along_, std::pair<double, std::size_t>(key(lamp) - width, 0));
    for (; at != along_.end() && at->first <= key(lamp) + width; ++at) {
      const Round& other = *all_[at->second];
      if (at->second == number || !(space_.length(apart(lamp, other)) <= near(lamp))) continue;
      const bool alike = shines(other.surface) && lamp.flip_normals == other.flip_normals;
      if (!alike || at->second < number) sum += 2 * near(lamp) + kClearance;
    }
    return sum;
  }

  const Normalization& space_;
  std::vector<Round*> all_;
  std::vector<std::pair<double, std::size_t>> along_;
  double near_ = 0;
};

}  // namespace

void bring_lamps_forward(SceneDescription& description, const Normalization& space) {
  FlatLamps(description, space).bring_forward();
  RoundLamps<SphereDescription>(description, space).bring_forward();
  RoundLamps<CylinderDescription>(description, space).bring_forward();
}

}  // namespace equaltime
