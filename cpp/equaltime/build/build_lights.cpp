#include "equaltime/build/build_lights.h"

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "equaltime/build/emission.h"
#include "equaltime/math/elementary.h"
#include "equaltime/scene/material.h"

namespace equaltime {

namespace {

/// Throws std::invalid_argument that names the light, such as spot light 3.
[[noreturn]] void fail_light(const std::string& light, const std::string& problem) {
  throw std::invalid_argument(light + ": " + problem);
}

Vec3d unit_direction(const Vec3d& direction, const std::string& light, const char* name = "direction") {
  const double norm = length(direction);
  if (!(norm > 0) || !std::isfinite(norm)) fail_light(light, std::string(name) + " needs a finite length above 0");
  return direction / norm;
}

SpotLight make_spot(const SpotLightDescription& s, const std::string& name, const std::vector<Texture>& textures,
                    const Normalization& normalization) {
  if (!is_finite(s.position)) fail_light(name, "position is not finite");
  if (!(0 <= s.beam_degrees && s.beam_degrees <= s.cutoff_degrees && 0 < s.cutoff_degrees && s.cutoff_degrees <= 180)) {
    std::ostringstream found;
    found << "beam is " << s.beam_degrees << " and cutoff " << s.cutoff_degrees
          << " degrees; expected 0 <= beam <= cutoff <= 180 degrees, and a cutoff above 0";
    fail_light(name, found.str());
  }
  constexpr double kRadians = std::numbers::pi / 180;
  const double cutoff = s.cutoff_degrees * kRadians, beam = s.beam_degrees * kRadians;
  Spectrum intensity = normalization.intensity(s.intensity);
  std::optional<ProjectedTexture> slide;
  if (s.texture) {
    if (*s.texture >= textures.size() || std::holds_alternative<MeshAttribute>(textures[*s.texture]))
      fail_light(name, "no texture " + std::to_string(*s.texture) + " that a spot light could project");
    if (s.cutoff_degrees > 90) fail_light(name, "a spot light with a texture needs a cutoff <= 90 degrees");
    const Texture& texture = textures[*s.texture];
    const double half = 0.5 / elementary::tan(cutoff);
    if (const auto color = constant(texture))
      intensity *= *color;
    else
      slide = ProjectedTexture{*s.texture, unit_direction(s.u_axis, name, "u_axis") * half,
                               unit_direction(s.v_axis, name, "v_axis") * half, mean_over_square(texture)};
  }
  return SpotLight(Vec3f(normalization.point(s.position)), unit_direction(s.direction, name), intensity, cutoff, beam,
                   slide);
}

}  // namespace

std::vector<DeltaLight> make_delta_lights(const SceneDescription& d, const std::vector<Texture>& textures,
                                          const Normalization& normalization) {
  std::vector<DeltaLight> lights;
  for (std::size_t i = 0; i < d.point_lights.size(); ++i) {
    const auto& [position, intensity] = d.point_lights[i];
    if (!is_finite(position)) fail_light("point light " + std::to_string(i), "position is not finite");
    lights.emplace_back(PointLight<float>{Vec3f(normalization.point(position)), normalization.intensity(intensity)});
  }
  for (std::size_t i = 0; i < d.spot_lights.size(); ++i)
    lights.emplace_back(make_spot(d.spot_lights[i], "spot light " + std::to_string(i), textures, normalization));
  for (std::size_t i = 0; i < d.directional_lights.size(); ++i) {
    const auto& [direction, irradiance] = d.directional_lights[i];
    lights.emplace_back(
        DirectionalLight<float>{Vec3f(-unit_direction(direction, "directional light " + std::to_string(i))),
                                normalization.radiance(irradiance)});
  }
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
  if (!(visit<kAllEffects>(*environment, [](const auto& e) { return e.total(); }) > 0)) environment.reset();
  return environment;
}

}  // namespace equaltime
