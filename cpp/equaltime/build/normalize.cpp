#include "equaltime/build/normalize.h"

#include <algorithm>
#include <cmath>

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"

namespace equaltime {

namespace {

void include_shape(Bounds& b, const MeshDescription& mesh) {
  for (const Vec3d& v : mesh.vertices) b.include(v);
  for (const std::vector<Vec3d>& later : mesh.later_vertices)
    for (const Vec3d& v : later) b.include(v);
}
void include_shape(Bounds& b, const RectangleDescription& r) {
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) b.include(r.to_world.point({x, y, 0}));
}
void include_shape(Bounds& b, const DiskDescription& d) {
  const Vec3d u = d.to_world.column(0), v = d.to_world.column(1), c = d.to_world.column(3);
  const Vec3d half{elementary::hypot(u.x, v.x), elementary::hypot(u.y, v.y), elementary::hypot(u.z, v.z)};
  b.include(c - half);
  b.include(c + half);
}
void include_shape(Bounds& b, const SphereDescription& s) {
  const Vec3d half{s.radius, s.radius, s.radius};
  b.include(s.center - half);
  b.include(s.center + half);
}
void include_shape(Bounds& b, const CylinderDescription& c) {
  const Vec3d half{c.radius, c.radius, c.radius};
  for (const Vec3d& end : {c.base, c.end}) {
    b.include(end - half);
    b.include(end + half);
  }
}

/// Of shapes; `groups` has the bounds of what their instances repeat.
Bounds bounds_of(const std::vector<ShapeDescription>& shapes, const std::vector<Bounds>& groups) {
  Bounds all;
  for (const ShapeDescription& shape : shapes) {
    const auto* instance = std::get_if<InstanceDescription>(&shape);
    if (instance == nullptr) {
      std::visit(
          [&](const auto& s) {
            if constexpr (requires { include_shape(all, s); }) include_shape(all, s);
          },
          shape);
    } else if (instance->group < groups.size() && !groups[instance->group].empty()) {
      const Bounds& b = groups[instance->group];
      if (!instance->keys.empty()) {
        all.include(Motion(instance->keys).swept(b));
        continue;
      }
      for (const double x : {b.lo.x, b.hi.x})
        for (const double y : {b.lo.y, b.hi.y})
          for (const double z : {b.lo.z, b.hi.z}) all.include(instance->to_world.point({x, y, z}));
    }
  }
  return all;
}

/// The largest value that any emitter's radiance takes, or a directional light's irradiance, in the user's units.
double brightest(const SceneDescription& d) {
  double most = 0;
  const auto look_at = [&](const ShapeDescription& shape) {
    std::visit(
        [&](const auto& s) {
          if constexpr (requires { s.surface; })
            if (s.surface.radiance) most = std::max(most, max_component(*s.surface.radiance));
        },
        shape);
  };
  std::for_each(d.shapes.begin(), d.shapes.end(), look_at);
  for (const GroupDescription& group : d.groups) std::for_each(group.shapes.begin(), group.shapes.end(), look_at);
  for (const DirectionalLightDescription& light : d.directional_lights)
    most = std::max(most, max_component(light.irradiance));
  if (!d.environment) return most;
  if (const auto* constant = std::get_if<ConstantEnvironmentDescription>(&*d.environment))
    return std::max(most, max_component(constant->radiance));
  const auto& image = std::get<ImageEnvironmentDescription>(*d.environment);
  for (const Spectrum& p : image.pixels) most = std::max(most, static_cast<double>(p.max_component()) * image.scale);
  return most;
}

bool stands_in_medium(const SceneDescription& d) noexcept {
  if (!d.camera_medium || *d.camera_medium >= d.media.size()) return false;
  return max_component(d.media[*d.camera_medium].sigma_t) > 0;
}

/// The camera belongs to the bounds: in a medium, its distance to the geometry matters.
void include_film(Bounds& b, const SceneDescription& d) {
  const Transform& t = placement(d.sensor);
  Bounds film;
  film.include(Vec3d{});
  if (std::holds_alternative<OrthographicDescription>(d.sensor)) {
    const double height = static_cast<double>(d.film.height) / d.film.width;
    film.include(Vec3d{-1, -height, 0});
    film.include(Vec3d{1, height, 0});
  }
  if (!d.sensor_keys.empty()) return b.include(Motion(d.sensor_keys).swept(film));
  for (const double x : {film.lo.x, film.hi.x})
    for (const double y : {film.lo.y, film.hi.y}) b.include(t.point({x, y, 0}));
}

}  // namespace

Normalization normalization_of(const GroupDescription& group) {
  const Bounds own = bounds_of(group.shapes, {});
  return {own.empty() ? Vec3d{} : own.center(), own};
}

Normalization normalization_of(const SceneDescription& description) {
  std::vector<Bounds> groups;
  for (const GroupDescription& group : description.groups) groups.push_back(bounds_of(group.shapes, {}));
  Bounds world = bounds_of(description.shapes, groups);
  const Vec3d camera = placement(description.sensor).column(3);
  if (stands_in_medium(description)) include_film(world, description);
  Normalization space(world.empty() ? camera : max(world.lo, min(world.hi, camera)), world);
  double most = brightest(description);
  const double across = space.length(1) / std::ldexp(1.0, Normalization::kExtentExponent);
  const auto seen_across_the_scene = [&](const Vec3d& intensity) { return max_component(intensity) * square(across); };
  for (const PointLightDescription& light : description.point_lights)
    most = std::max(most, seen_across_the_scene(light.intensity));
  for (const SpotLightDescription& light : description.spot_lights)
    most = std::max(most, seen_across_the_scene(light.intensity));
  space.fit_radiance(most);
  return space;
}

}  // namespace equaltime
