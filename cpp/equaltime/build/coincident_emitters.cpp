#include "equaltime/build/coincident_emitters.h"

#include <algorithm>
#include <cmath>
#include <concepts>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "equaltime/build/build_meshes.h"
#include "equaltime/math/elementary.h"
#include "equaltime/scene/surface.h"

namespace equaltime {

namespace {

/// How far an emitter is moved beyond what its own and the surface's rounding need: what float32 leaves of the length
/// of a ray across the scene, which is up to 2^11 long.
constexpr double kClearance = 16 * static_cast<double>(kUnitRoundoff) * 0x1p11;
/// Corners of the polygon round a disk.
constexpr int kDiskCorners = 24;
/// Pairs of coincident emitters, for each emitter on average, that a scene may have: more are no scene that is meant,
/// and take time that grows with their square.
constexpr std::size_t kMostPairs = 64;

using Polygon = std::vector<Vec3d>;

/// One triangle of the scene. What is no instance is part 0 of itself, and what rests has one place, 0.
struct FaceName {
  std::size_t shape, part, number;
  std::size_t place;

  auto operator<=>(const FaceName&) const = default;
  [[nodiscard]] bool same_part(const FaceName& other) const noexcept {
    return shape == other.shape && part == other.part;
  }
};

/// A triangle in normalised space. Its winding gives the normal, and an emitter emits to that side.
struct Face {
  std::array<Vec3d, 3> v;
  Vec3d n;
  double margin;  // how far float32 and Embree may see it from its plane
  FaceName name;
  bool emits;

  [[nodiscard]] Bounds bounds() const noexcept {
    Bounds b;
    for (const Vec3d& p : v) b.include(p - Vec3d{margin, margin, margin}), b.include(p + Vec3d{margin, margin, margin});
    return b;
  }
};

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
    const double turn = 2 * std::numbers::pi / kDiskCorners, reach = 1 / elementary::cos(0.5 * turn);
    corners[static_cast<std::size_t>(i)] = {reach * elementary::cos(i * turn), reach * elementary::sin(i * turn)};
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

/// How high a face reaches above the emitter's plane, if the two are one within rounding where they overlap.
std::optional<double> coincidence(const Face& emitter, const Face& face) {
  const double near = 4 * (emitter.margin + face.margin);
  const Polygon shared = common(face, emitter);
  const double sides = length(emitter.v[1] - emitter.v[0]) + length(emitter.v[2] - emitter.v[0]);
  if (shared.size() < 3 || !(area(shared) > near * sides)) return std::nullopt;
  double highest = -near;
  for (const Vec3d& p : shared) {
    const double h = dot(emitter.n, p - emitter.v[0]);
    if (std::abs(h) > near) return std::nullopt;
    highest = std::max(highest, h);
  }
  return highest + near + kClearance;
}

/// The faces of emitters, in a tree of boxes: each node holds a range, halved at the middle of its longest side.
class EmitterTree {
 public:
  explicit EmitterTree(std::vector<Face>& faces) : faces_(faces) { build(0, faces.size()); }
  /// Tells whether the box overlaps the box of any emitter.
  [[nodiscard]] bool touches(const Bounds& box) const {
    bool found = false;
    find(box, [&](std::size_t emitter) { found = found || touch(faces_[emitter].bounds(), box); });
    return found;
  }
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
    if (!touch(boxes_[node], box)) return;
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

[[nodiscard]] bool emits_light(const SurfaceDescription& s) noexcept {
  return s.radiance && max_component(*s.radiance) > 0;
}

/// Whether triangles stand for a kind of shape.
template <class S>
concept Flat = requires(const S& s) {
  for_each_triangle(s, [](auto&&...) {});
};

/// The places at which an instance is compared: an emitter that slides in a surface lies in it at both ends of its
/// motion.
std::vector<Transform> places(const InstanceDescription& instance) {
  if (instance.keys.empty()) return {instance.to_world};
  if (stays(instance.keys)) return {instance.keys.front().to_world};
  return {instance.keys.front().to_world, instance.keys.back().to_world};
}

/// The vector that a transform takes to `v`.
Vec3d before(const Transform& transform, const Vec3d& v) noexcept {
  const Vec3d x = transform.column(0), y = transform.column(1), z = transform.column(2);
  return Vec3d{dot(cross(y, z), v), dot(cross(z, x), v), dot(cross(x, y), v)} / dot(x, cross(y, z));
}

/// Flat emitters.
class FlatEmitters {
 public:
  FlatEmitters(SceneDescription& description, const Normalization& space)
      : description_(description), space_(space), emitters_(collected()), lifts_(emitters_.size(), 0) {}

  void bring_forward() {
    if (emitters_.empty()) return;
    const EmitterTree tree(emitters_);
    const double widened = margin();
    for (std::size_t shape = 0; shape < description_.shapes.size(); ++shape) compare_all(tree, shape, widened);
    raise_above_emitters();
    for (std::size_t i = 0; i < emitters_.size(); ++i)
      if (lifts_[i] > 0) lift(emitters_[i], lifts_[i]);
  }

 private:
  /// One emitter before another that emits to the same side.
  struct Above {
    std::size_t emitter;
    FaceName below;
    double by;
  };

  [[nodiscard]] std::optional<Face> face(const std::array<Vec3d, 3>& corners) const {
    const std::array<Vec3d, 3> v = {space_.point(corners[0]), space_.point(corners[1]), space_.point(corners[2])};
    const Vec3d normal = cross(v[1] - v[0], v[2] - v[0]);
    const double size = length(normal);
    if (!(size > 0) || !std::isfinite(size)) return std::nullopt;
    const auto margin = static_cast<double>(triangle_plane(Vec3f(v[0]), Vec3f(v[1]), Vec3f(v[2])).offset);
    if (!std::isfinite(margin)) return std::nullopt;  // no area is left in float32
    return Face{v, normal / size, margin, {}, false};
  }

  /// Calls f with every face of a shape, wherever it is looked at, of those parts that `wanted` admits: it is called
  /// with the part, its place, whether it emits, and whether it is instanced. An instance is rounded once more; it
  /// emits if it moves.
  template <class Wanted, class F>
  void for_each_face(std::size_t shape, Wanted&& wanted, F&& f) const {
    const auto look_at = [&]<class S>(const S& s, const Transform& placed, FaceName name, const auto* instance) {
      if constexpr (Flat<S>) {
        const bool emits = emits_light(s.surface) && (instance == nullptr || !instance->keys.empty());
        if (!wanted(s, placed, emits, instance != nullptr)) return;
        const bool mirrored = dot(cross(placed.column(0), placed.column(1)), placed.column(2)) < 0;
        for_each_triangle(s, [&](const Vec3d& a, const Vec3d& b, const Vec3d& c, std::size_t number) {
          auto found = face({placed.point(a), placed.point(mirrored ? c : b), placed.point(mirrored ? b : c)});
          if (!found) return;
          name.number = number;
          found->name = name, found->emits = emits;
          if (instance != nullptr) found->margin *= 4;
          f(*found);
        });
      }
    };
    const ShapeDescription& described = description_.shapes[shape];
    const auto* instance = std::get_if<InstanceDescription>(&described);
    if (instance == nullptr)
      return std::visit([&](const auto& s) { look_at(s, Transform(), {shape, 0, 0, 0}, instance); }, described);
    if (instance->group >= description_.groups.size()) return;
    const std::vector<ShapeDescription>& parts = description_.groups[instance->group].shapes;
    const std::vector<Transform> at = places(*instance);
    for (std::size_t part = 0; part < parts.size(); ++part)
      for (std::size_t place = 0; place < at.size(); ++place)
        std::visit([&](const auto& s) { look_at(s, at[place], {shape, part, 0, place}, instance); }, parts[part]);
  }

  [[nodiscard]] std::vector<Face> collected() const {
    std::vector<Face> emitters;
    for (std::size_t shape = 0; shape < description_.shapes.size(); ++shape)
      for_each_face(
          shape, [](const auto&, const Transform&, bool emits, bool) { return emits; },
          [&](const Face& face) { emitters.push_back(face); });
    return emitters;
  }

  /// How far the box of a face's corners is from an emitter's box at most if the two can be one: `coincidence` asks for
  /// a shared area of more than 4 `margin` times the emitter's sides, and the emitter's area is an eighth of their
  /// square.
  [[nodiscard]] double margin() const noexcept {
    double widest = 0;
    for (const Face& emitter : emitters_)
      widest = std::max(widest, length(emitter.v[1] - emitter.v[0]) + length(emitter.v[2] - emitter.v[0]));
    return widest / 32 + kClearance;
  }

  /// The box of a mesh's vertices in normalised space, widened by `more`.
  [[nodiscard]] Bounds box_of(const MeshDescription& mesh, const Transform& placed, double more) {
    auto [at, fresh] = boxes_.try_emplace(&mesh);
    if (fresh)
      for (const Vec3d& p : mesh.vertices) at->second.include(p);
    Bounds box;
    for (int corner = 0; corner < 8; ++corner) {
      const Bounds& own = at->second;
      const Vec3d p =
          space_.point(placed.point({(corner & 1) != 0 ? own.hi.x : own.lo.x, (corner & 2) != 0 ? own.hi.y : own.lo.y,
                                     (corner & 4) != 0 ? own.hi.z : own.lo.z}));
      box.include(p - Vec3d{more, more, more}), box.include(p + Vec3d{more, more, more});
    }
    return box;
  }

  /// Compares the faces of a shape with emitters. Instances of a mesh that lie far from every emitter are passed over,
  /// so that very many take no longer than few.
  void compare_all(const EmitterTree& tree, std::size_t shape, double margin) {
    const auto wanted = [&]<class S>(const S& part, const Transform& placed, bool, bool instanced) {
      if constexpr (std::same_as<S, MeshDescription>) return !instanced || tree.touches(box_of(part, placed, margin));
      return true;
    };
    for_each_face(shape, wanted, [&](const Face& other) {
      tree.find(other.bounds(), [&](std::size_t emitter) { compare(emitter, other); });
    });
  }

  void compare(std::size_t number, const Face& other) {
    const FaceName &emitter = emitters_[number].name, &name = other.name;
    if (emitter == name || (emitter.shape == name.shape && emitter.place != name.place)) return;
    const auto by = coincidence(emitters_[number], other);
    if (!by) return;
    if (emitter.same_part(name))
      fail(emitter.shape, "its triangles " + std::to_string(name.number) + " and " + std::to_string(emitter.number) +
                              " emit from one place: leave one of them out, or make them two shapes");
    if (other.emits && ++pairs_ > kMostPairs * emitters_.size())
      fail(emitter.shape, "too many emitters lie in one place: leave all but one of them out");
    if (!other.emits || dot(emitters_[number].n, other.n) < 0)
      lifts_[number] = std::max(lifts_[number], *by);
    else if (name < emitter)
      above_.push_back({number, name, *by});
  }

  void raise_above_emitters() {
    std::map<FaceName, std::size_t> numbers;
    for (std::size_t i = 0; !above_.empty() && i < emitters_.size(); ++i) numbers[emitters_[i].name] = i;
    std::ranges::sort(above_, {}, [&](const Above& a) { return emitters_[a.emitter].name; });
    for (const auto& [emitter, below, by] : above_)
      lifts_[emitter] = std::max(lifts_[emitter], lifts_[numbers.at(below)] + by);
  }

  /// Moves the shape of a face, in its own space, so that the face is as high above its place as it shall be, or
  /// higher.
  void lift(const Face& emitter, double by) {
    ShapeDescription* shape = &description_.shapes[emitter.name.shape];
    Transform to_world;
    if (const auto* instance = std::get_if<InstanceDescription>(shape)) {
      to_world = places(*instance)[emitter.name.place];
      shape = &description_.groups[instance->group].shapes[emitter.name.part];
    }
    std::vector<Vec3d>& moved = moved_[{emitter.name.shape, emitter.name.part}];
    auto* mesh = std::get_if<MeshDescription>(shape);
    moved.resize(mesh != nullptr ? mesh->vertices.size() : 1);
    const auto move = [&](std::size_t i) {
      const double already = dot(emitter.n, to_world.vector(moved[i]));
      const Vec3d step = before(to_world, emitter.n * std::max(0.0, space_.world_length(by) - already));
      moved[i] += step;
      return step;
    };
    if (mesh != nullptr)
      for (const std::uint32_t i : mesh->triangles[emitter.name.number]) mesh->vertices[i] += move(i);
    else if (auto* rectangle = std::get_if<RectangleDescription>(shape))
      translate(rectangle->to_world, move(0));
    else if (auto* disk = std::get_if<DiskDescription>(shape))
      translate(disk->to_world, move(0));
  }
  static void translate(Transform& t, const Vec3d& by) noexcept {
    t.m[0][3] += by.x, t.m[1][3] += by.y, t.m[2][3] += by.z;
  }

  SceneDescription& description_;
  const Normalization& space_;
  std::vector<Face> emitters_;
  std::vector<double> lifts_;  // of each, in normalised space
  std::vector<Above> above_;
  std::size_t pairs_ = 0;                           // of emitters
  std::map<const MeshDescription*, Bounds> boxes_;  // of instanced meshes, in their own space
  /// How far a part of a shape, or each vertex of a mesh, is moved in its own space.
  std::map<std::pair<std::size_t, std::size_t>, std::vector<Vec3d>> moved_;
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

/// Emitters that are spheres, or cylinders: their radius changes. Those that are one lie next to each other along a
/// direction across which no grid is likely to be aligned.
template <class Round>
class RoundEmitters {
 public:
  RoundEmitters(SceneDescription& description, const Normalization& space) : space_(space) {
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
    for (std::size_t i = 0; i < all_.size(); ++i) lifts.push_back(emits_light(all_[i]->surface) ? lift(i) : 0);
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
  /// Before all that are one with an emitter, unless they come later and emit to the same side.
  [[nodiscard]] double lift(std::size_t number) const noexcept {
    const Round& emitter = *all_[number];
    double sum = 0;
    const double width = near_ * length(kDirection);
    auto at = std::ranges::lower_bound(along_, std::pair<double, std::size_t>(key(emitter) - width, 0));
    for (; at != along_.end() && at->first <= key(emitter) + width; ++at) {
      const Round& other = *all_[at->second];
      if (at->second == number || !(space_.length(apart(emitter, other)) <= near(emitter))) continue;
      const bool alike = emits_light(other.surface) && emitter.flip_normals == other.flip_normals;
      if (!alike || at->second < number) sum += 2 * near(emitter) + kClearance;
    }
    return sum;
  }

  const Normalization& space_;
  std::vector<Round*> all_;
  std::vector<std::pair<double, std::size_t>> along_;
  double near_ = 0;
};

}  // namespace

void bring_emitters_forward(SceneDescription& description, const Normalization& space) {
  FlatEmitters(description, space).bring_forward();
  RoundEmitters<SphereDescription>(description, space).bring_forward();
  RoundEmitters<CylinderDescription>(description, space).bring_forward();
}

}  // namespace equaltime
