#include "equaltime/build/build_meshes.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "equaltime/base/release.h"
#include "equaltime/math/frame.h"

namespace equaltime {

void fail(std::size_t shape, const std::string& problem) { throw ShapeError(shape, problem); }

namespace {

std::vector<Vec3f> placed_vertices(std::size_t index, const std::vector<Vec3d>& vertices, const Normalization& space) {
  std::vector<Vec3f> out;
  out.reserve(vertices.size() + 1);
  for (const Vec3d& v : vertices) {
    if (!is_finite(v)) fail(index, "vertex " + std::to_string(out.size()) + " is not finite");
    out.push_back(Vec3f(space.point(v)));
  }
  return out;
}

/// Whether a triangle has no area, whenever.
bool is_flat(const TriangleMesh& mesh, const Triangle& t) noexcept {
  const auto flat = [&t](const std::vector<Vec3f>& vertices) {
    const Vec3d a(vertices[t[0]]);
    return length_squared(cross(Vec3d(vertices[t[1]]) - a, Vec3d(vertices[t[2]]) - a)) == 0;
  };
  return flat(mesh.vertices) && std::all_of(mesh.later.begin(), mesh.later.end(), flat);
}

}  // namespace

TriangleMesh placed_mesh(std::size_t index, MeshDescription& mesh, const Normalization& space) {
  TriangleMesh out;
  out.vertices = placed_vertices(index, mesh.vertices, space);
  for (const std::vector<Vec3d>& later : mesh.later_vertices) {
    if (later.size() != mesh.vertices.size()) fail(index, "a mesh has the same vertices at all times");
    out.later.push_back(placed_vertices(index, later, space));
  }
  if (std::all_of(out.later.begin(), out.later.end(), [&](const auto& later) { return later == out.vertices; }))
    out.later.clear();
  if (!mesh.normals.empty() && mesh.normals.size() != mesh.vertices.size())
    fail(index, "a mesh has as many normals as vertices, or none");
  if (!mesh.uvs.empty() && mesh.uvs.size() != mesh.vertices.size())
    fail(index, "a mesh has as many uvs as vertices, or none");
  out.triangles = std::move(mesh.triangles);
  release(mesh.vertices, mesh.later_vertices);
  return out;
}

std::size_t drop_degenerate(std::size_t index, TriangleMesh& mesh, std::vector<AttributeValues>& attributes) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto degenerate = [&](const Triangle& t) {
    for (const std::uint32_t i : t)
      if (i >= count) fail(index, "vertex index " + std::to_string(i) + " of " + std::to_string(count) + " vertices");
    return is_flat(mesh, t);
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (degenerate(mesh.triangles[i])) continue;
    for (AttributeValues& a : attributes)
      if (a.per_face && (i + 1) * a.width <= a.values.size())
        std::copy_n(&a.values[i * a.width], a.width, &a.values[kept * a.width]);
    mesh.triangles[kept++] = mesh.triangles[i];
  }
  const std::size_t dropped = mesh.triangles.size() - kept;
  for (AttributeValues& a : attributes)
    if (a.per_face && a.values.size() == mesh.triangles.size() * a.width) a.values.resize(kept * a.width);
  mesh.triangles.resize(kept);
  return dropped;
}

void add_attributes(std::uint32_t shape, const TriangleMesh& mesh, std::vector<AttributeValues>& attributes,
                    std::vector<Texture>& textures) {
  for (AttributeValues& values : attributes) {
    auto* texture = values.texture < textures.size() ? std::get_if<MeshAttribute>(&textures[values.texture]) : nullptr;
    if (texture == nullptr) fail(shape, "texture " + std::to_string(values.texture) + " is no attribute of a mesh");
    try {
      texture->add(shape, std::move(values), mesh.vertices.size(), mesh.triangles.size());
    } catch (const std::invalid_argument& wrong) {
      fail(shape, wrong.what());
    }
  }
}

std::vector<Vec3f> triangle_tangents(const TriangleMesh& mesh, const std::vector<std::array<double, 2>>& uvs) {
  std::vector<Vec3f> tangents;
  tangents.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<Vec3f, 3> corners = {mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]};
    tangents.push_back(triangle_tangent(corners, uvs.empty() ? kBarycentric : std::array{uvs[a], uvs[b], uvs[c]}));
  }
  return tangents;
}

std::vector<Point2f> float_uvs(std::size_t shape, const std::vector<std::array<double, 2>>& uvs) {
  std::vector<Point2f> out;
  out.reserve(uvs.size());
  for (const auto& [u, v] : uvs) {
    out.push_back({static_cast<float>(u), static_cast<float>(v)});
    if (!std::isfinite(out.back().x) || !std::isfinite(out.back().y))
      fail(shape, "texture coordinate " + std::to_string(out.size() - 1) + " is not finite in single precision");
  }
  return out;
}

namespace {

MeshView view_of(const TriangleMesh& mesh, const Surface& surface, std::uint32_t shape) noexcept {
  const MeshAttributes& of_mesh = surface.mesh;
  return {mesh.triangles.data(),
          mesh.vertices.data(),
          of_mesh.planes.data(),
          of_mesh.normals.empty() ? nullptr : of_mesh.normals.data(),
          of_mesh.tangents.empty() ? nullptr : of_mesh.tangents.data(),
          of_mesh.uvs.empty() ? nullptr : of_mesh.uvs.data(),
          surface.textured,
          shape,
          surface.flipped};
}

}  // namespace

std::vector<MeshView> view_meshes(const Accel& accel, const ShapeRange& top, const std::vector<ShapeRange>& groups,
                                  const std::vector<std::uint32_t>& mesh_shapes, const std::vector<Surface>& surfaces) {
  std::vector<MeshView> views;
  const auto add = [&](const ShapeRange& set, const Geometries& all) {
    for (std::uint32_t i = 0; i < set.mesh_count; ++i) {
      const std::uint32_t shape = mesh_shapes[set.first_mesh + i];
      views.push_back(view_of(all.meshes[i], surfaces[shape], shape));
    }
  };
  add(top, accel.geometries());
  for (std::size_t i = 0; i < groups.size(); ++i) add(groups[i], accel.groups()[i]);
  return views;
}

std::vector<InstanceGeometry> place_instances(const std::vector<InstanceDescription>& instances,
                                              const std::vector<Normalization>& groups, const Normalization& world) {
  std::vector<InstanceGeometry> placed;
  placed.reserve(instances.size());
  for (const auto& [group, to_world, keys] : instances) {
    const Normalization& own = groups[group];
    const double scale = world.length(1) / own.length(1);
    const Vec3f columns[4] = {Vec3f(to_world.column(0) * scale), Vec3f(to_world.column(1) * scale),
                              Vec3f(to_world.column(2) * scale),
                              Vec3f(world.point(to_world.point(own.world_point({}))))};
    InstanceGeometry& geometry = placed.emplace_back(InstanceGeometry{group, {}});
    for (std::size_t i = 0; i < 4; ++i) {
      geometry.to_world[3 * i] = columns[i].x;
      geometry.to_world[3 * i + 1] = columns[i].y;
      geometry.to_world[3 * i + 2] = columns[i].z;
    }
  }
  return placed;
}

std::vector<std::optional<std::size_t>> only_instances(const std::vector<ShapeDescription>& shapes,
                                                       std::size_t groups) {
  std::vector<std::optional<std::size_t>> only(groups);
  std::vector<bool> seen(groups);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const auto* instance = std::get_if<InstanceDescription>(&shapes[i]);
    if (instance == nullptr || instance->group >= groups) continue;
    if (seen[instance->group])
      only[instance->group] = std::nullopt;
    else
      only[instance->group] = i;
    seen[instance->group] = true;
  }
  return only;
}

void set_azimuth(Surface& surface, const Vec3d& axis, const Vec3d& meridian, bool mirrored) noexcept {
  const FrameD axes = FrameD::from_tangent(axis, meridian);
  surface.analytic.azimuth[0] = Vec3f(axes.s);
  surface.analytic.azimuth[1] = Vec3f(mirrored ? -axes.t : axes.t);
}

std::vector<MovingInstanceGeometry> move_instances(const std::vector<InstanceDescription>& instances,
                                                   const std::vector<Normalization>& groups,
                                                   const Normalization& world) {
  std::vector<MovingInstanceGeometry> moving;
  for (const auto& [group, to_world, keys] : instances)
    moving.push_back({group, Motion(keys).between(groups[group].space(), world.space())});
  return moving;
}

void deform(std::size_t index, const MeshDescription& from, const TriangleMesh& mesh, Surface& surface) {
  if (mesh.later.empty()) return;
  if (!surface.emission.radiance.is_black()) fail(index, "a mesh that deforms cannot emit");
  if (from.normals.empty()) return;
  if (from.later_normals.size() != mesh.later.size()) fail(index, "a mesh has normals at all times, or at none");
  for (const std::vector<Vec3d>& later : from.later_normals) {
    if (later.size() != mesh.vertices.size()) fail(index, "a mesh has as many normals as vertices, or none");
    std::vector<Vec3f>& normals = surface.mesh.later_normals.emplace_back();
    for (const Vec3d& n : later) normals.push_back(Vec3f(n));
  }
}

std::vector<std::optional<DeformingMesh>> deforming_meshes(const Accel& accel, const std::vector<MeshView>& views,
                                                           const std::vector<ShapeRange>& groups,
                                                           const std::vector<Surface>& surfaces) {
  std::vector<std::optional<DeformingMesh>> all(views.size());
  bool any = false;
  const auto add = [&](std::size_t first, const Geometries& geometries) {
    for (std::size_t i = 0; i < geometries.meshes.size(); ++i)
      if (const TriangleMesh& mesh = geometries.meshes[i]; !mesh.later.empty()) {
        all[first + i] = DeformingMesh{&mesh, &surfaces[views[first + i].shape].mesh};
        any = true;
      }
  };
  add(0, accel.geometries());
  for (std::size_t i = 0; i < groups.size(); ++i) add(groups[i].first_mesh, accel.groups()[i]);
  if (!any) all.clear();
  return all;
}

}  // namespace equaltime
