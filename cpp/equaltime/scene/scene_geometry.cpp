#include "equaltime/scene/scene_geometry.h"

#include "equaltime/math/elementary.h"
#include "equaltime/scene/held_bytes.h"

namespace equaltime {

namespace {

constexpr float kTurn = 2 * kPi;

/// Derivatives of a triangle's point by u and v, as in Mitsuba. Without texture coordinates they are the edges. If the
/// coordinates are degenerate, they are tangents of length `unit`.
Derivatives on_mesh(const MeshView& mesh, std::uint32_t primitive, const std::array<Vec3f, 3>& corners, const Vec3d& n,
                    float unit) noexcept {
  const Vec3d v0(corners[0]);
  const Vec3d e1 = Vec3d(corners[1]) - v0, e2 = Vec3d(corners[2]) - v0;
  if (mesh.uvs == nullptr) return {Vec3f(e1), Vec3f(e2)};
  const auto& [a, b, c] = mesh.triangles[primitive];
  const double u1 = mesh.uvs[b].x - mesh.uvs[a].x, w1 = mesh.uvs[b].y - mesh.uvs[a].y;
  const double u2 = mesh.uvs[c].x - mesh.uvs[a].x, w2 = mesh.uvs[c].y - mesh.uvs[a].y;
  const double determinant = u1 * w2 - u2 * w1;
  if (determinant != 0) return {Vec3f((e1 * w2 - e2 * w1) / determinant), Vec3f((e2 * u1 - e1 * u2) / determinant)};
  const FrameD frame = FrameD::from_normal(n);
  return {Vec3f(frame.s) * unit, Vec3f(frame.t) * unit};
}

/// The directions away from the axis of a surface, and round it, at an azimuth in turns.
struct Azimuth {
  Vec3f outward, around;

  Azimuth(const ShapeParametrization& s, float turns) noexcept {
    const auto [sine, cosine] = sin_cos(kTurn * turns);
    outward = s.azimuth[0] * cosine + s.azimuth[1] * sine;
    around = s.azimuth[1] * cosine - s.azimuth[0] * sine;
  }
};

// Derivatives of the point of an analytic shape.

Derivatives on(std::type_identity<Sphere<float>>, const ShapeParametrization& s, Point2f uv) noexcept {
  const auto [outward, around] = Azimuth(s, uv.x);
  const auto [sin_polar, cos_polar] = sin_cos(kPi * uv.y);
  return {around * (kTurn * s.radius * sin_polar), (outward * cos_polar - s.pole * sin_polar) * (kPi * s.radius)};
}
Derivatives on(std::type_identity<Disk<float>>, const ShapeParametrization& s, Point2f uv) noexcept {
  const auto [outward, around] = Azimuth(s, uv.y);
  return {outward, around * (kTurn * uv.x)};
}
Derivatives on(std::type_identity<Cylinder<float>>, const ShapeParametrization& s, Point2f uv) noexcept {
  return {Azimuth(s, uv.x).around * (kTurn * s.radius), s.pole};
}

std::size_t held_by(const Geometries& all) noexcept {
  std::size_t bytes = held(all.meshes);
  std::apply([&](const auto&... lists) { ((bytes += held(lists)), ...); }, all.analytic);
  for (const TriangleMesh& mesh : all.meshes) {
    bytes += held(mesh.vertices) + held(mesh.triangles) + held(mesh.later);
    for (const std::vector<Vec3f>& later : mesh.later) bytes += held(later);
  }
  return bytes;
}

std::size_t held_by(const MeshAttributes& mesh) noexcept {
  std::size_t bytes =
      held(mesh.planes) + held(mesh.normals) + held(mesh.tangents) + held(mesh.uvs) + held(mesh.later_normals);
  for (const std::vector<Vec3f>& later : mesh.later_normals) bytes += held(later);
  return bytes;
}

}  // namespace

TextureCoords SceneGeometry::texture_coords(std::uint32_t shape, std::uint32_t primitive,
                                            Point2f on_primitive) const noexcept {
  const std::uint32_t mesh = surfaces[shape].mesh.number;
  if (mesh == kNone) return {on_primitive, shape, primitive};
  return on_triangle(on_primitive, shape, primitive, meshes[mesh].triangles[primitive], meshes[mesh].uvs);
}

std::array<Vec3f, 3> SceneGeometry::corners(std::uint32_t mesh, std::uint32_t primitive, float time) const noexcept {
  if (!deforming.empty() && deforming[mesh]) return deforming[mesh]->corners(primitive, time);
  const auto& [a, b, c] = meshes[mesh].triangles[primitive];
  const Vec3f* vertices = meshes[mesh].vertices;
  return {vertices[a], vertices[b], vertices[c]};
}

Derivatives SceneGeometry::derivatives(const Interaction& it, float time) const noexcept {
  if (it.instance != kNone) {
    Interaction local = it;
    local.instance = kNone;
    const auto [du, dv] = derivatives(local, time);
    const Instance instance = instance_at(it.instance, time);
    return {instance.to_world(du), instance.to_world(dv)};
  }
  const Surface& s = surfaces[it.shape];
  if (const std::uint32_t mesh = s.mesh.number; mesh != kNone) {
    const bool deforms = !deforming.empty() && deforming[mesh];
    const Vec3d n = deforms ? deforming[mesh]->plane(it.primitive, time).n : meshes[mesh].planes[it.primitive].n;
    return on_mesh(meshes[mesh], it.primitive, corners(mesh, it.primitive, time), n, s.mesh.unit);
  }
  return AnalyticShapes::at(s.analytic.kind, [&]<class Shape>(std::type_identity<Shape> kind) noexcept {
    return on(kind, s.analytic, it.prim_uv);
  });
}

std::size_t SceneGeometry::triangle_count() const noexcept {
  std::size_t n = 0;
  for (const Surface& surface : surfaces) n += surface.mesh.planes.size();
  return n;
}

std::size_t SceneGeometry::memory_bytes() const noexcept {
  std::size_t bytes = accel.memory_bytes() + held_by(accel.geometries()) + held(accel.groups());
  for (const Geometries& group : accel.groups()) bytes += held_by(group);
  bytes +=
      held(surfaces) + held(groups) + held(instances) + held(moving) + held(deforming) + held(meshes) + held(emitters);
  for (const std::vector<std::uint32_t>& shapes : analytic_shapes) bytes += held(shapes);
  for (const MovingInstanceGeometry& instance : moving) bytes += instance.to_world.memory_bytes();
  for (const Surface& surface : surfaces) bytes += held_by(surface.mesh);
  return bytes;
}

}  // namespace equaltime
