// The albedo of a surface at a point, for outputs beside the image, which denoisers read: in [0, 1] everywhere. For
// models with a diffuse part it is that part's colour, whatever reflects above it, as in Mitsuba; for others the share
// of the light that the surface sends on, all directions together, where it is seen from.
#pragma once

#include <algorithm>
#include <optional>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/scene/shading.h"

namespace equaltime {

template <Effects E>
[[nodiscard]] Spectrum output_albedo(const Scene& scene, std::uint32_t material, const Interaction& it) noexcept {
  if (material == kNone) return {};
  const Material& m = scene.appearance.materials[material];
  if (m.kind == Material::Kind::null) return {};
  if (m.kind == Material::Kind::mixture) {
    const auto part = [&](int i) noexcept { return output_albedo<E>(scene, m.parts[i], it); };
    if (scene.appearance.materials[m.parts[0]].kind == Material::Kind::null)
      return part(1);  // a mask hides nothing of it
    const float w = m.weight_at(scene.appearance.textures, scene.geometry.texture_coords(it));
    return part(0) * (1 - w) + part(1) * w;
  }
  Interaction at = it;
  std::optional<Bsdf> own;
  scene.tilt_frame<E>(material, at, 0);
  const Bsdf& bsdf = scene.bsdf<E>(material, at, own);
  const Spectrum found = visit<E>(bsdf, [&](const auto& model) noexcept -> Spectrum {
    if constexpr (requires { model.diffuse_reflectance; })
      return model.diffuse_reflectance;
    else if constexpr (requires { model.base_color; })
      return model.base_color;
    else if constexpr (requires { model.reflectance; })
      return model.reflectance;
    else
      return albedo<E>(at, bsdf);
  });
  const auto clamped = [](float value) noexcept { return std::clamp(value, 0.0F, 1.0F); };
  return {clamped(found.r), clamped(found.g), clamped(found.b)};
}

}  // namespace equaltime
