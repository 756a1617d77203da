// Shapes are validated here, and named by number.
#include "equaltime/build/build_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "equaltime/base/release.h"
#include "equaltime/base/threads.h"
#include "equaltime/build/build_lights.h"
#include "equaltime/build/build_materials.h"
#include "equaltime/build/build_media.h"
#include "equaltime/build/build_meshes.h"
#include "equaltime/build/build_nesting.h"
#include "equaltime/build/build_sensor.h"
#include "equaltime/build/check_description.h"
#include "equaltime/build/coincident_emitters.h"
#include "equaltime/build/emission.h"
#include "equaltime/build/normalize.h"
#include "equaltime/build/part_names.h"

namespace equaltime {

namespace {

/// Edges of a rectangle this close to orthogonal are sampled as a rectangle, others as two triangles.
constexpr double kOrthogonal = 1e-6;

class Builder {
 public:
  explicit Builder(SceneDescription& d)
      : description_(d), normalization_(normalization_of(d)), space_(normalization_) {}

  Scene build(Intersection mode);

 private:
  static double orientation(const Transform& t) noexcept { return dot(cross(t.column(0), t.column(1)), t.column(2)); }

  std::uint32_t add_surface(const SurfaceDescription& d, bool flipped);
  void add(std::size_t index, MeshDescription& mesh);
  void add(std::size_t index, RectangleDescription& rectangle);
  void add(std::size_t index, DiskDescription& disk);
  void add(std::size_t index, SphereDescription& sphere);
  void add(std::size_t index, CylinderDescription& cylinder);
  void add(std::size_t index, InstanceDescription& instance);
  template <class Shape, class MakeLight>
  void add_analytic(std::size_t index, const Shape& shape, Surface& surface, MakeLight&& make_light);
  ShapeRange add_set(std::vector<ShapeDescription>& shapes);
  void add_groups();
  void move_group(std::size_t first_shape, std::size_t first_light);
  void add_mesh(std::size_t shape, TriangleMesh mesh);
  void check_reach(const std::vector<InstanceGeometry>& placed) const;
  Lights make_lights();
  [[nodiscard]] std::size_t textured_emitters() const;

  SceneDescription& description_;
  Normalization normalization_;
  Normalization space_;  // that of the set being built
  std::vector<Texture> textures_;
  BsdfTables bsdf_tables_;
  std::vector<Material> materials_;
  Media media_;
  std::vector<Surface> surfaces_;
  Geometries geometries_;  // of the set being built
  std::vector<Normalization> group_spaces_;
  std::vector<ShapeRange> group_sets_;
  std::vector<Geometries> groups_;
  std::vector<InstanceDescription> instances_, moving_;
  std::vector<MovingLights> moving_lights_;
  std::vector<std::optional<std::size_t>> only_instances_;  // of each group
  bool in_group_ = false;                                   // the set being built is one
  std::vector<std::uint32_t> mesh_shapes_;
  std::array<std::vector<std::uint32_t>, AnalyticShapes::size> analytic_shapes_;
  AreaLightBuilder area_lights_{textures_};
  std::size_t dropped_triangles_ = 0;
};

std::uint32_t Builder::add_surface(const SurfaceDescription& d, bool flipped) {
  Surface surface;
  for (const auto& [side, bsdf] : {std::pair{0, d.front}, std::pair{1, d.back}}) {
    if (!bsdf) continue;
    if (*bsdf >= materials_.size())
      fail(surfaces_.size(), std::string(side == 0 ? "front" : "back") + " is BSDF " + std::to_string(*bsdf) +
                                 "; expected an index below " + std::to_string(materials_.size()));
    surface.material[side] = resolve_constant_blend(materials_, *bsdf);
    const Material& material = materials_[surface.material[side]];
    surface.textured = surface.textured || material.textured;
    surface.anisotropic = surface.anisotropic || material.anisotropic;
  }
  if (d.radiance) surface.emission.radiance = normalization_.radiance(*d.radiance);
  if (d.emission) area_lights_.set_emission(surface, surfaces_.size(), *d.emission);
  surface.textured = surface.textured || description_.keeps_uvs;
  for (const auto& [side, medium] : {std::pair{0, d.exterior}, std::pair{1, d.interior}}) {
    if (medium && *medium >= media_.index.size()) fail(surfaces_.size(), "no medium " + std::to_string(*medium));
    surface.media.sides[side] = media_.at(medium);
  }
  surface.media.sets_medium = d.exterior || d.interior;
  surface.flipped = flipped;
  surfaces_.push_back(std::move(surface));
  return static_cast<std::uint32_t>(surfaces_.size() - 1);
}

void Builder::add_mesh(std::size_t shape, TriangleMesh mesh) {
  std::vector<TrianglePlane<float>>& planes = surfaces_[shape].mesh.planes;
  planes.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles)
    planes.push_back(triangle_plane(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]));
  surfaces_[shape].mesh.number = static_cast<std::uint32_t>(mesh_shapes_.size());
  surfaces_[shape].mesh.unit = static_cast<float>(space_.length(1));
  mesh_shapes_.push_back(static_cast<std::uint32_t>(shape));
  geometries_.meshes.push_back(std::move(mesh));
}

void Builder::add(std::size_t index, MeshDescription& mesh) {
  TriangleMesh out = placed_mesh(index, mesh, space_);
  dropped_triangles_ += drop_degenerate(index, out, mesh.attributes);
  add_attributes(static_cast<std::uint32_t>(index), out, mesh.attributes, textures_);
  Surface& surface = surfaces_[add_surface(mesh.surface, false)];
  surface.mesh.normals.reserve(mesh.normals.size());
  for (const Vec3d& n : mesh.normals) surface.mesh.normals.push_back(Vec3f(n));
  deform(index, mesh, out, surface);
  release(mesh.normals, mesh.later_normals);
  if (surface.anisotropic) surface.mesh.tangents = triangle_tangents(out, mesh.uvs);
  if (surface.textured || (surface.anisotropic && !out.later.empty())) surface.mesh.uvs = float_uvs(index, mesh.uvs);
  release(mesh.uvs);
  area_lights_.add_triangles(index, out, surface, false);
  add_mesh(index, std::move(out));
}

void Builder::add(std::size_t index, RectangleDescription& r) {
  TriangleMesh out;
  for (const auto& [x, y] : {std::pair{-1, -1}, std::pair{1, -1}, std::pair{1, 1}, std::pair{-1, 1}})
    out.vertices.push_back(Vec3f(space_.point(r.to_world.point({static_cast<double>(x), static_cast<double>(y), 0}))));
  out.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Vec3d corner(out.vertices[0]);
  const Vec3d edge_x = Vec3d(out.vertices[1]) - corner, edge_y = Vec3d(out.vertices[3]) - corner;
  if (!(length_squared(cross(edge_x, edge_y)) > 0)) fail(index, "a rectangle needs an area");
  const bool flipped = r.flip_normals != (orientation(r.to_world) < 0);
  Surface& surface = surfaces_[add_surface(r.surface, flipped)];
  if (surface.textured) surface.mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  if (surface.anisotropic) surface.mesh.tangents.assign(2, Vec3f(edge_x));
  if (in_group_ || std::abs(dot(edge_x, edge_y)) > kOrthogonal * length(edge_x) * length(edge_y)) {
    area_lights_.add_triangles(index, out, surface, flipped);
  } else if (!surface.emission.radiance.is_black()) {
    area_lights_.add_rectangle(surface, index, out.vertices[0], edge_x, edge_y, flipped);
  }
  add_mesh(index, std::move(out));
}

/// Adds the geometry of a shape, and its light if it emits: `make_light` makes one of a radiance.
template <class Shape, class MakeLight>
void Builder::add_analytic(std::size_t index, const Shape& shape, Surface& surface, MakeLight&& make_light) {
  constexpr std::size_t kKind = AnalyticShapes::place_of<Shape>;
  std::vector<Shape>& all = geometries_.of<Shape>();
  surface.analytic.kind = kKind;
  if (!surface.emission.radiance.is_black())
    area_lights_.add(surface, index, all.size(), make_light(area_lights_.mean_radiance(surface.emission)));
  all.push_back(shape);
  analytic_shapes_[kKind].push_back(static_cast<std::uint32_t>(index));
}

void Builder::add(std::size_t index, DiskDescription& d) {
  const Vec3d center = space_.point(d.to_world.column(3));
  const double scale = space_.length(1);
  const Vec3d u = d.to_world.column(0) * scale, v = d.to_world.column(1) * scale;
  const Vec3d scaled_normal = cross(u, v);
  const double area = length(scaled_normal);
  if (!(area > 0) || !is_finite(center)) fail(index, "a disk needs an area");
  const Vec3d n = scaled_normal / area;
  const Disk<float> disk{center, n, cross(v, n) / dot(u, cross(v, n)), cross(n, u) / dot(v, cross(n, u))};
  const bool flipped = d.flip_normals != (orientation(d.to_world) < 0);
  Surface& surface = surfaces_[add_surface(d.surface, flipped)];
  surface.analytic.azimuth[0] = Vec3f(u), surface.analytic.azimuth[1] = Vec3f(v);
  add_analytic(index, disk, surface,
               [&](const Spectrum& radiance) { return DiskLight(center, u, v, flipped, radiance); });
}

void Builder::add(std::size_t index, SphereDescription& s) {
  if (!(s.radius > 0) || !std::isfinite(s.radius) || !is_finite(s.center))
    fail(index, "a sphere needs a finite centre and a positive radius");
  const Vec3d center = space_.point(s.center);
  const double radius = space_.length(s.radius);
  Surface& surface = surfaces_[add_surface(s.surface, s.flip_normals)];
  surface.analytic.pole = Vec3f(s.pole);
  set_azimuth(surface, s.pole, s.meridian, s.mirrored);
  surface.analytic.radius = static_cast<float>(radius);
  add_analytic(index, Sphere<float>{center, radius}, surface,
               [&](const Spectrum& radiance) { return SphereLight(center, radius, s.flip_normals, radiance); });
}

void Builder::add(std::size_t index, CylinderDescription& c) {
  const Vec3d base = space_.point(c.base), axis = space_.point(c.end) - base;
  const double height = length(axis), radius = space_.length(c.radius);
  if (!(height > 0) || !(radius > 0) || !std::isfinite(height) || !std::isfinite(radius))
    fail(index, "a cylinder needs two finite ends that differ, and a positive radius");
  const Cylinder<float> cylinder{base, axis / height, height, radius};
  Surface& surface = surfaces_[add_surface(c.surface, c.flip_normals)];
  set_azimuth(surface, cylinder.axis, c.meridian, c.mirrored);
  surface.analytic.radius = static_cast<float>(radius);
  surface.analytic.pole = Vec3f(axis);
  add_analytic(index, cylinder, surface,
               [&](const Spectrum& radiance) { return CylinderLight(cylinder, c.flip_normals, radiance); });
}

void Builder::add(std::size_t index, InstanceDescription& instance) {
  if (in_group_) fail(index, "a group cannot hold instances");
  if (instance.group >= description_.groups.size()) fail(index, "an instance of no group");
  if (!instance.keys.empty() && stays(instance.keys))
    instance.to_world = instance.keys.front().to_world, instance.keys.clear();
  const double size = std::abs(orientation(instance.to_world));
  if (!(size > 0) || !std::isfinite(size) || !is_finite(instance.to_world.column(3)))
    fail(index, "to_world of an instance must be finite and have an inverse");
  surfaces_.emplace_back();
  (instance.keys.empty() ? instances_ : moving_).push_back(instance);
}

/// Adds shapes to the set being built, and returns where they are.
ShapeRange Builder::add_set(std::vector<ShapeDescription>& shapes) {
  const auto count = [](const auto& list) { return static_cast<std::uint32_t>(list.size()); };
  ShapeRange set{count(mesh_shapes_), 0};
  std::ranges::transform(analytic_shapes_, set.first.begin(), count);
  for (ShapeDescription& shape : shapes) std::visit([&](auto& s) { add(surfaces_.size(), s); }, shape);
  set.mesh_count = count(mesh_shapes_) - set.first_mesh;
  return set;
}

void Builder::add_groups() {
  only_instances_ = only_instances(description_.shapes, description_.groups.size());
  for (GroupDescription& group : description_.groups) {
    space_ = group_spaces_.emplace_back(normalization_of(group));
    const std::size_t lights = area_lights_.lights.size(), first = surfaces_.size();
    in_group_ = true;
    group_sets_.push_back(add_set(group.shapes));
    move_group(first, lights);
    groups_.push_back(std::exchange(geometries_, {}));
  }
}

/// Sees to the group that was built last, if its only instance moves: it is that shape, and may have lights.
void Builder::move_group(std::size_t first_shape, std::size_t first_light) {
  const std::optional<std::size_t> only = only_instances_[group_sets_.size() - 1];
  const auto* owner = only ? std::get_if<InstanceDescription>(&description_.shapes[*only]) : nullptr;
  const bool moves = owner && !owner->keys.empty(), emits = area_lights_.lights.size() > first_light;
  if (emits && !moves) fail(first_shape, "the shapes of a group cannot emit, unless its only instance moves");
  for (std::size_t i = first_shape; moves && i < surfaces_.size(); ++i)
    surfaces_[i].source_shape = static_cast<std::uint32_t>(*only);
  if (!emits) return;
  MovingInstanceGeometry instance = move_instances({*owner}, group_spaces_, normalization_).front();
  moving_lights_.push_back(moving_lights(area_lights_.lights, first_light, std::move(instance)));
}

/// Refuses instances whose groups see the scene's extent, near 2^10, from beyond what Embree takes.
void Builder::check_reach(const std::vector<InstanceGeometry>& placed) const {
  constexpr double kLeast = 0x1p13;
  std::size_t n = 0;
  for (std::size_t i = 0; i < description_.shapes.size(); ++i) {
    const auto* instance = std::get_if<InstanceDescription>(&description_.shapes[i]);
    if (instance == nullptr || !instance->keys.empty()) continue;
    if (!(Accel::reach(placed[n++]) >= kLeast))
      fail(i, "to_world of an instance makes the group more than 10^14 times smaller than the scene, along some axis");
  }
}

Lights Builder::make_lights() {
  const Bounds& bounds = normalization_.bounds();
  const double reach = bounds.empty() ? 0 : 0.5 * length(bounds.extent()), radius = reach > 0 ? reach : 1;
  return Lights(std::move(area_lights_.lights), make_delta_lights(description_, textures_, normalization_),
                make_environment(description_, normalization_), radius, std::move(moving_lights_));
}

std::size_t Builder::textured_emitters() const {
  std::size_t count = 0;
  const auto look = [&](const std::vector<ShapeDescription>& shapes) {
    for (const ShapeDescription& shape : shapes)
      std::visit(
          [&](const auto& s) {
            if constexpr (requires { s.surface; }) count += s.surface.radiance && s.surface.emission;
          },
          shape);
  };
  look(description_.shapes);
  for (const GroupDescription& group : description_.groups) look(group.shapes);
  return std::max<std::size_t>(count, 1);
}

Scene Builder::build(Intersection mode) {
  bring_emitters_forward(description_, normalization_);
  area_lights_.textured_emitters = textured_emitters();
  textures_ = make_textures(std::move(description_.textures));
  materials_ = make_materials(description_, textures_, normalization_.length(1), bsdf_tables_);
  media_ = make_media(description_.media, normalization_);
  surfaces_.reserve(description_.shapes.size());
  const ShapeRange top = add_set(description_.shapes);
  Geometries own = std::exchange(geometries_, {});
  add_groups();
  Lights lights = make_lights();
  const FilmDescription& film = description_.film;
  const std::vector<InstanceGeometry> placed = place_instances(instances_, group_spaces_, normalization_);
  check_reach(placed);
  std::vector<MovingInstanceGeometry> moving = move_instances(moving_, group_spaces_, normalization_);
  Accel accel(std::move(own), mode, std::move(groups_), placed, moving);
  std::vector<MeshView> views = view_meshes(accel, top, group_sets_, mesh_shapes_, surfaces_);
  std::vector<std::optional<DeformingMesh>> deforming = deforming_meshes(accel, views, group_sets_, surfaces_);
  const std::vector<Instance> instances(placed.begin(), placed.end());
  const std::optional<CameraMotion> camera_motion = make_camera_motion(description_, normalization_);
  Nesting nesting = make_nesting(description_,
                                 {materials_, accel.geometries(), accel.groups(), instances, moving, camera_motion, top,
                                  group_sets_, only_instances_, mesh_shapes_, analytic_shapes_},
                                 normalization_.point(placement(description_.sensor).column(3)),
                                 media_.at(description_.camera_medium), surfaces_);
  const bool by_number =  // lights are asked which surface they are
      !nesting.dielectrics.empty() ||
      std::any_of(surfaces_.begin(), surfaces_.end(), [](const Surface& s) { return s.emission.texture != kNone; });
  const bool lets_light_pass =
      !nesting.dielectrics.empty() || std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Surface& s) {
        return std::any_of(s.material, s.material + 2,
                           [&](std::uint32_t i) { return i != kNone && materials_[i].passes; });
      });
  return {.geometry = {.accel = std::move(accel),
                       .surfaces = std::move(surfaces_),
                       .top = top,
                       .groups = std::move(group_sets_),
                       .instances = instances,
                       .moving = std::move(moving),
                       .meshes = std::move(views),
                       .deforming = std::move(deforming),
                       .analytic_shapes = std::move(analytic_shapes_),
                       .emitters = by_number ? std::move(area_lights_.emitters) : std::vector<Emitter>(),
                       .dropped_triangles = dropped_triangles_},
          .appearance = {std::move(bsdf_tables_), std::move(materials_), std::move(textures_), lets_light_pass},
          .volumes = {std::move(media_.dense), std::move(media_.phases), std::move(nesting)},
          .lights = std::move(lights),
          .camera = {make_sensor(description_, normalization_), camera_motion,
                     PixelFilter(film.filter, film.filter_parameter, film.second_filter_parameter), film},
          .rules = {description_.count_null_interfaces, description_.hides_emitters},
          .normalization = normalization_};
}

/// Leaves the description with its shapes, but without what they hold.
Scene build(SceneDescription& description, const BuildOptions& options) {
  const FilmDescription& film = description.film;
  if (film.crop_width == 0 || film.crop_height == 0 || std::uint64_t{film.crop_x} + film.crop_width > film.width ||
      std::uint64_t{film.crop_y} + film.crop_height > film.height)
    throw std::invalid_argument("the film's crop is empty or reaches beyond the film: it has " +
                                std::to_string(film.crop_width) + " x " + std::to_string(film.crop_height) +
                                " pixels from (" + std::to_string(film.crop_x) + ", " + std::to_string(film.crop_y) +
                                "), and the film has " + std::to_string(film.width) + " x " +
                                std::to_string(film.height));
  std::vector<MotionKey>& keys = description.sensor_keys;
  if (!keys.empty()) place(description.sensor, keys.front().to_world);
  if (stays(keys)) keys.clear();
  if (options.threads == 0) return Builder(description).build(options.intersection);
  std::optional<Scene> scene;
  in_arena(options.threads, [&] { scene.emplace(Builder(description).build(options.intersection)); });
  return std::move(*scene);
}

}  // namespace

Scene build_scene(SceneDescription description, const BuildOptions& options) {
  check(description);
  try {
    return build(description, options);
  } catch (const ShapeError& error) {
    throw std::invalid_argument(numbered_shape_name(description, error.shape()) + ": " + error.problem());
  }
}

Scene build_checked_scene(SceneDescription description, const BuildOptions& options) {
  return build(description, options);
}

}  // namespace equaltime
