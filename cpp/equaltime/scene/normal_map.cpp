// Normal and bump maps: the shading frame of a point as a texture bends it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

namespace {

/// The height's rise along u and v leans the surface by so much; towards the side of the geometric normal.
Vec3f bumped(const Derivatives& d, Point2f rise, const Vec3f& n, const Vec3f& geometric) noexcept {
  const Vec3f u = d.du + n * (rise.x - dot(n, d.du)), v = d.dv + n * (rise.y - dot(n, d.dv));
  const Vec3f bent = cross(u, v);
  return dot(bent, geometric) < 0 ? -bent : bent;
}

}  // namespace

void Scene::bend(const NormalMap& b, Interaction& it, float time) const noexcept {
  const Derivatives d = geometry.derivatives(it, time);
  const Texture& texture = appearance.textures[b.texture];
  const Vec3f n = it.frame.n;
  const float side = it.front ? 1.0F : -1.0F;
  const Vec3f front = n * side;
  Vec3f bent;
  if (b.bump) {
    const Point2f rise = gradient(texture, geometry.texture_coords(it));
    bent = bumped(d, {b.scale * rise.x, b.scale * rise.y}, front, it.anchor.n * side);
  } else {
    const Spectrum c = eval(texture, geometry.texture_coords(it));
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
