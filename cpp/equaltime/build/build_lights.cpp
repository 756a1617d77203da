#include "equaltime/build/build_lights.h"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "equaltime/build/emission.h"
#include "equaltime/scene/material.h"

namespace equaltime {

namespace {

Vec3d unit_direction(const Vec3d& direction, const char* of) {
  const double norm = length(direction);
  if (!(norm > 0) || !std::isfinite(norm)) throw std::invalid_argument(std::string(of) + " needs a direction");
  return direction / norm;
}

SpotLight make_spot(const SpotLightDescription& s, const std::vector<Texture>& textures,
                    const Normalization& normalization) {
  if (!is_finite(s.position)) throw std::invalid_argument("a spot light's position is not finite");
  if (!(0 <= s.beam_degrees && s.beam_degrees <= s.cutoff_degrees && 0 < s.cutoff_degrees && s.cutoff_degrees <= 180))
    throw std::invalid_argument("a spot light needs 0 <= beam <= cutoff <= 180 degrees, and a cutoff above 0");
  constexpr double kRadians = std::numbers::pi / 180;
  const double cutoff = s.cutoff_degrees * kRadians, beam = s.beam_degrees * kRadians;
  Spectrum intensity = normalization.intensity(s.intensity);
  std::optional<Slide> slide;
  if (s.texture) {
    if (*s.texture >= textures.size() || std::holds_alternative<MeshAttribute>(textures[*s.texture]))
      throw std::invalid_argument("no texture " + std::to_string(*s.texture) + " that a spot light could project");
    if (s.cutoff_degrees > 90) throw std::invalid_argument("a spot light with a texture needs a cutoff <= 90 degrees");
    const Texture& texture = textures[*s.texture];
    const double half = 0.5 / std::tan(cutoff);
    if (const auto color = constant(texture))
      intensity *= *color;
    else
      slide = Slide{*s.texture, unit_direction(s.u_axis, "a spot light's texture") * half,
                    unit_direction(s.v_axis, "a spot light's texture") * half, mean_over_square(texture)};
  }
  return SpotLight(Vec3f(normalization.point(s.position)), unit_direction(s.direction, "a spot light"), intensity,
                   cutoff, beam, slide);
}

}  // namespace

std::vector<DeltaLight> make_delta_lights(const SceneDescription& d, const std::vector<Texture>& textures,
                                          const Normalization& normalization) {
  std::vector<DeltaLight> lights;
  for (const PointLightDescription& p : d.point_lights) {
    if (!is_finite(p.position)) throw std::invalid_argument("a point light's position is not finite");
    lights.emplace_back(PointLight{Vec3f(normalization.point(p.position)), normalization.intensity(p.intensity)});
  }
  for (const SpotLightDescription& s : d.spot_lights) lights.emplace_back(make_spot(s, textures, normalization));
  for (const DirectionalLightDescription& l : d.directional_lights)
    lights.emplace_back(DirectionalLight{Vec3f(-unit_direction(l.direction, "a directional light")),
                                         normalization.radiance(l.irradiance)});
  return lights;
}

std::optional<Environment> make_environment(SceneDescription& d, const Normalization& normalization) {
  if (!d.environment) return std::nullopt;
  std::optional<Environment> environment;
  if (const auto* constant = std::get_if<ConstantEnvironmentDescription>(&*d.environment))
    environment = ConstantEnvironment(normalization.radiance(constant->radiance));
  else
    environment = ImageEnvironment(std::move(std::get<ImageEnvironmentDescription>(*d.environment)),
                                   normalization.radiance_scale());
  // A black environment is none: it lights nothing and calls for nothing.
  if (!(std::visit([](const auto& e) { return e.total(); }, *environment) > 0)) environment.reset();
  return environment;
}

}  // namespace equaltime
