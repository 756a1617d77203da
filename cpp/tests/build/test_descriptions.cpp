// Numbers of a description that cannot be are refused, by name, before anything is built.
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace scenes;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The message with which a scene is refused; empty if it is built.
std::string refusal(const std::function<void(SceneDescription&)>& change) {
  SceneDescription description = full_room();
  change(description);
  try {
    (void)build_scene(std::move(description));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

bool refuses(BsdfDescription bsdf, const std::string& word) {
  const std::string message = refusal([&](SceneDescription& d) { d.bsdfs[1] = std::move(bsdf); });
  return message.starts_with("BSDF 1: ") && message.find(word) != std::string::npos;
}

TEST("a room as it is, and numbers at the ends of their ranges, are built") {
  CHECK(refusal([](SceneDescription&) {}).empty());
  CHECK(refusal([](SceneDescription& d) { d.bsdfs[1] = DiffuseDescription{{0, 1, 1}}; }).empty());
  CHECK(refusal([](SceneDescription& d) { d.bsdfs[0] = DielectricDescription{1e6}; }).empty());
}

TEST("a BSDF's numbers are refused by their names") {
  CHECK(refuses(DiffuseDescription{{0.5, kNaN, 0.5}}, "reflectance is nan"));
  CHECK(refuses(DiffuseDescription{{0.5, 1.5, 0.5}}, "reflectance is 1.5"));
  CHECK(refuses(ConductorDescription{{-1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, "eta is -1"));
  CHECK(refuses(RoughConductorDescription{MicrofacetModel::ggx, 0, 0.1, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
                "alpha_u is 0"));
  CHECK(refuses(DielectricDescription{0}, "ior is 0"));
  CHECK(refuses(ThinDielectricDescription{kNaN}, "ior is nan"));
  CHECK(refuses(RoughDielectricDescription{.alpha_v = -1}, "alpha_v is -1"));
  CHECK(refuses(PlasticDescription{1e12}, "ior is 1e+12"));
  CHECK(refuses(RoughPlasticDescription{.alpha = kNaN}, "alpha is nan"));
  CHECK(refuses(PrincipledDescription{.clearcoat = 2}, "clearcoat is 2"));
  CHECK(refuses(MixtureDescription{0, 0, -0.25}, "weight is -0.25"));
  CHECK(refuses(MixtureDescription{0, 0, 0.5, -1}, "cutoff is -1"));
}

TEST("light that is negative or no number is refused") {
  const auto refused = [](const std::string& part, const std::string& found, const auto& change) {
    const std::string message = refusal(change);
    return message.starts_with(part) && message.find(found) != std::string::npos;
  };
  CHECK(refused("shape 3: ", "radiance is -1", [](SceneDescription& d) {
    std::get<RectangleDescription>(d.shapes[3]).surface.radiance = {1, -1, 1};
  }));
  CHECK(refused("point light ", "intensity is nan", [](SceneDescription& d) {
    d.point_lights.push_back({{0, 1, 0}, {1, kNaN, 1}});
  }));
  CHECK(refused("spot light ", "intensity is inf", [](SceneDescription& d) {
    d.spot_lights.push_back({{0, 1, 0}, {0, -1, 0}, {HUGE_VAL, 1, 1}});
  }));
  CHECK(refused("directional light ", "irradiance is -2", [](SceneDescription& d) {
    d.directional_lights.push_back({{0, 1, 0}, {-2, 0, 0}});
  }));
  CHECK(refused("environment: ", "radiance is nan", [](SceneDescription& d) {
    d.environment = ConstantEnvironmentDescription{{kNaN, 0, 0}};
  }));
  CHECK(refused("environment: ", "found 3 pixels", [](SceneDescription& d) {
    d.environment = ImageEnvironmentDescription{2, 2, {{}, {}, {}}, 1, {}};
  }));
  CHECK(refused("environment: ", "a pixel is -1", [](SceneDescription& d) {
    d.environment = ImageEnvironmentDescription{1, 1, {{1, -1, 1}}, 1, {}};
  }));
  CHECK(refused("group ", "shape 0: radiance is -1", [](SceneDescription& d) {
    SurfaceDescription dark;
    dark.radiance = Vec3d{-1, 0, 0};
    d.groups.push_back({{SphereDescription{{}, 1, false, dark}}});
  }));
}

TEST("a sensor without an angle, or with one of half a turn, is refused") {
  const auto with_view = [](const std::function<void(PerspectiveDescription&)>& change) {
    return refusal([&](SceneDescription& d) {
      PerspectiveDescription view{placement(d.sensor), 40, {}, {}};
      change(view);
      d.sensor = view;
    });
  };
  CHECK(with_view([](PerspectiveDescription&) {}).empty());
  for (const double angle : {0.0, 180.0, -20.0, kNaN})
    CHECK(with_view([&](PerspectiveDescription& v) { v.x_fov_degrees = angle; }).starts_with("sensor: x_fov_degrees"));
  CHECK(with_view([](PerspectiveDescription& v) { v.to_world.m[0][3] = kNaN; }).starts_with("sensor: an entry"));
  CHECK(with_view([](PerspectiveDescription& v) { v.near = 2, v.far = 1; }).starts_with("sensor: far_clip is 1"));
  CHECK(with_view([](PerspectiveDescription& v) { v.near = 2, v.far = 2; }).starts_with("sensor: far_clip is 2"));
  CHECK(with_view([](PerspectiveDescription& v) { v.far = 0; }).starts_with("sensor: far_clip is 0"));
  CHECK(with_view([](PerspectiveDescription& v) { v.near = 1, v.far = 2; }).empty());
}

}  // namespace

int main() { return check::run(); }
