#include "equaltime/scene/moving_lights.h"

namespace equaltime {

AreaLight MovingLights::at(std::uint32_t light, float time) const noexcept {
  const AffineMap now = instance.to_world.at(static_cast<double>(time));
  return std::visit(
      [&](const auto& l) -> AreaLight {
        if constexpr (requires { l.placed(now); })
          return l.placed(now);
        else
          return l;
      },
      local[light - first]);
}

Optional<LightSample<float>> MovingLights::with_offset(Optional<LightSample<float>> sample, float time) const noexcept {
  if (!sample) return sample;
  OffsetPoint<float>& target = sample->target;
  const Instance now(instance.group, instance.to_world.at(static_cast<double>(time)));
  target.offset += now.position_error(target.p, target.n);
  return sample;
}

LightBounds MovingLights::bounds(std::uint32_t light) const noexcept {
  const auto of = [](const AreaLight& any) { return std::visit([](const auto& l) { return l.bounds(); }, any); };
  LightBounds all = of(at(light, kReferenceTime));
  all.box = instance.to_world.swept(of(local[light - first]).box);
  all.radius = 0.5 * length(all.box.extent());
  if (instance.to_world.turns()) all.normals = {};
  return all;
}

MovingLights moving_lights(std::vector<AreaLight>& lights, std::size_t begin, MovingInstanceGeometry instance) {
  const auto first = lights.begin() + static_cast<std::ptrdiff_t>(begin);
  MovingLights moving{static_cast<std::uint32_t>(begin), std::vector<AreaLight>(first, lights.end()),
                      std::move(instance)};
  if (moving.instance.to_world.at(0).mirrors())  // whose triangles have their corners in another order
    for (AreaLight& light : moving.local)
      if (const auto* picture = std::get_if<TexturedTriangle>(&light)) light = AreaLight(picture->even());
  for (std::size_t i = begin; i < lights.size(); ++i)
    lights[i] = moving.at(static_cast<std::uint32_t>(i), MovingLights::kReferenceTime);
  return moving;
}

}  // namespace equaltime
