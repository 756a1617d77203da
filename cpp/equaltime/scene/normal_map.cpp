// Normal and bump maps: the shading frame of a point as a texture bends it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

namespace {

constexpr float kTurn = 2 * kPi;

/// How the point of a triangle moves with u and v: along its edges with barycentric ones. Where uvs do not tell, as
/// Frame makes it of the normal, as long as the author's unit. All as in Mitsuba.
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

/// The height's rise along u and v leans the surface by so much; towards the side of the geometric normal.
Vec3f bumped(const Derivatives& d, Point2f rise, const Vec3f& n, const Vec3f& geometric) noexcept {
  const Vec3f u = d.du + n * (rise.x - dot(n, d.du)), v = d.dv + n * (rise.y - dot(n, d.dv));
  const Vec3f bent = cross(u, v);
  return dot(bent, geometric) < 0 ? -bent : bent;
}

}  // namespace

Derivatives Scene::derivatives(const Interaction& it, float time) const noexcept {
  if (it.instance != kNone) {
    Interaction local = it;
    local.instance = kNone;
    const auto [du, dv] = derivatives(local, time);
    const Instance instance = instance_at(it.instance, time);
    return {instance.to_world(du), instance.to_world(dv)};
  }
  const Surface& s = surfaces[it.shape];
  if (s.mesh != kNone) {
    const bool deforms = !deforming.empty() && deforming[s.mesh];
    const Vec3d n = deforms ? deforming[s.mesh]->plane(it.primitive, time).n : meshes[s.mesh].planes[it.primitive].n;
    return on_mesh(meshes[s.mesh], it.primitive, corners(s.mesh, it.primitive, time), n, s.size);
  }
  const float turns = kTurn * (s.kind == SurfaceKind::disk ? it.place.y : it.place.x);
  const auto [sin_turns, cos_turns] = sin_cos(turns);
  const Vec3f outward = s.azimuth[0] * cos_turns + s.azimuth[1] * sin_turns;
  const Vec3f around = s.azimuth[1] * cos_turns - s.azimuth[0] * sin_turns;
  if (s.kind == SurfaceKind::disk) return {outward, around * (kTurn * it.place.x)};
  if (s.kind == SurfaceKind::cylinder) return {around * (kTurn * s.size), s.pole};
  const auto [sin_polar, cos_polar] = sin_cos(kPi * it.place.y);
  return {around * (kTurn * s.size * sin_polar), (outward * cos_polar - s.pole * sin_polar) * (kPi * s.size)};
}

void Scene::bend(const NormalMap& b, Interaction& it, float time) const noexcept {
  const Derivatives d = derivatives(it, time);
  const Texture& texture = textures[b.texture];
  const Vec3f n = it.frame.n;
  const float side = it.front ? 1.0F : -1.0F;
  const Vec3f front = n * side;
  Vec3f bent;
  if (b.bump) {
    const Point2f rise = gradient(texture, place(it));
    bent = bumped(d, {b.scale * rise.x, b.scale * rise.y}, front, it.anchor.n * side);
  } else {
    const Spectrum c = eval(texture, place(it));
    bent = Frame::from_tangent(front, d.du).to_world({2 * c.r - 1, 2 * c.g - 1, 2 * c.b - 1});
  }
  if (!(length_squared(bent) > 0)) return;
  bent = normalize(bent);
  if (!it.front) bent = b.turned ? -bent : bent - front * (2 * dot(bent, front));
  if (b.flip_invalid && dot(bent, it.wo) <= 0) bent = n * (2 * dot(bent, n)) - bent;
  const float cosine = dot(bent, n);
  it.unbent = n;
  it.shadowing = b.shadowing ? std::clamp((1 - cosine * cosine) / (8 * cosine * cosine), 0.0F, 1.0F) : 0.0F;
  it.smooth = true;
  it.frame = Frame::from_tangent(bent, d.du);
}

}  // namespace equaltime
