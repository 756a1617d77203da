// Normal and bump maps: a texture perturbs the shading frame of a point.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "equaltime/math/elementary.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

namespace {

/// Normal of the surface displaced by a height with this gradient; on the side of the geometric normal.
Vec3f bumped(const Derivatives& d, Point2f rise, const Vec3f& n, const Vec3f& geometric) noexcept {
  const Vec3f u = d.du + n * (rise.x - dot(n, d.du)), v = d.dv + n * (rise.y - dot(n, d.dv));
  const Vec3f perturbed = cross(u, v);
  return dot(perturbed, geometric) < 0 ? -perturbed : perturbed;
}

}  // namespace

void Scene::apply_normal_map(const NormalMap& b, Interaction& it, float time) const noexcept {
  const Derivatives d = geometry.derivatives(it, time);
  const Texture& texture = appearance.textures[b.texture];
  const Vec3f n = it.frame.n;
  const float side = it.front ? 1.0F : -1.0F;
  const Vec3f front = n * side;
  Vec3f perturbed;
  if (b.bump) {
    const Point2f rise = gradient(texture, geometry.texture_coords(it));
    perturbed = bumped(d, {b.scale * rise.x, b.scale * rise.y}, front, it.anchor.n * side);
  } else {
    const Spectrum c = eval(texture, geometry.texture_coords(it));
    perturbed = Frame::from_tangent(front, d.du).to_world({2 * c.r - 1, 2 * c.g - 1, 2 * c.b - 1});
  }
  if (!(length_squared(perturbed) > 0)) return;
  perturbed = normalize(perturbed);
  if (!it.front) perturbed = b.negate_back ? -perturbed : perturbed - front * (2 * dot(perturbed, front));
  if (b.flip_invalid && dot(perturbed, it.wo) <= 0) perturbed = n * (2 * dot(perturbed, n)) - perturbed;
  const float cosine = dot(perturbed, n);
  it.unperturbed_normal = n;
  it.terminator_alpha2 = b.shadowing ? std::clamp((1 - cosine * cosine) / (8 * cosine * cosine), 0.0F, 1.0F) : 0.0F;
  it.smooth = true;
  it.frame = Frame::from_tangent(perturbed, d.du);
}

}  // namespace equaltime
