// The diffuse reflectance of a surface at a point, for outputs beside the image: what a denoiser calls albedo. By
// Mitsuba's rule: the colour of the diffuse part for models that have one, whatever reflects above it; for others π
// times what comes back when light falls straight on, without what goes into discrete directions.
#pragma once

#include <numbers>
#include <optional>

#include "scene/scene.h"
#include "scene/shading.h"

namespace equaltime {

template <auto E>
[[nodiscard]] Spectrum diffuse_reflectance(const Scene& scene, std::uint32_t material, const Interaction& it) noexcept {
  if (material == kNone) return {};
  const Material& m = scene.materials[material];
  if (m.kind == Material::Kind::nothing) return {};
  if (m.kind == Material::Kind::mixture) {
    const auto part = [&](int i) noexcept { return diffuse_reflectance<E>(scene, m.parts[i], it); };
    if (scene.materials[m.parts[0]].kind == Material::Kind::nothing) return part(1);  // a mask hides nothing of it
    const float w = m.weight_at(scene.textures, scene.place(it));
    return part(0) * (1 - w) + part(1) * w;
  }
  Interaction at = it;
  std::optional<Bsdf> own;
  return visit<E>(scene.bsdf<E>(material, at, own, 0), [&](const auto& model) noexcept -> Spectrum {
    if constexpr (requires { model.diffuse_reflectance; })
      return model.diffuse_reflectance;
    else if constexpr (requires { model.base_color; })
      return model.base_color;
    else if constexpr (requires { model.reflectance; })
      return model.reflectance;
    else
      return model.eval(at.frame.to_local(at.wo), {0, 0, 1}, at.front).f * std::numbers::pi_v<float>;
  });
}

}  // namespace equaltime
