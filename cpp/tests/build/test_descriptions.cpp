// Numbers of a description that cannot be are refused, by name, before anything is built.
#include <cmath>
#include <cstdio>
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

/// Whether a scene is refused for a part, such as "BSDF 1", and the message goes on as told.
bool refuses(const std::string& part, const std::string& problem,
             const std::function<void(SceneDescription&)>& change) {
  const bool refused = refusal(change).starts_with(part + ": " + problem);
  if (!refused) std::printf("  the scene is refused by: %s\n", refusal(change).c_str());
  return refused;
}

bool refuses(BsdfDescription bsdf, const std::string& kind, const std::string& problem) {
  return refuses("BSDF 1 (" + kind + ")", problem, [&](SceneDescription& d) { d.bsdfs[1] = bsdf; });
}

TEST("a room as it is, and numbers at the ends of their ranges, are built") {
  CHECK(refusal([](SceneDescription&) {}).empty());
  CHECK(refusal([](SceneDescription& d) { d.bsdfs[1] = DiffuseDescription{{0, 1, 1}}; }).empty());
  CHECK(refusal([](SceneDescription& d) { d.bsdfs[0] = DielectricDescription{1e6}; }).empty());
}

TEST("a BSDF's numbers are refused by their names") {
  CHECK(refuses(DiffuseDescription{{0.5, kNaN, 0.5}}, "diffuse", "reflectance is nan"));
  CHECK(refuses(DiffuseDescription{{0.5, 1.5, 0.5}}, "diffuse", "reflectance is 1.5"));
  CHECK(refuses(ConductorDescription{{-1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, "conductor", "eta is -1"));
  CHECK(refuses(RoughConductorDescription{MicrofacetModel::ggx, 0, 0.1, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
                "roughconductor", "alpha_u is 0"));
  CHECK(refuses(DielectricDescription{0}, "dielectric", "ior is 0"));
  CHECK(refuses(ThinDielectricDescription{kNaN}, "thindielectric", "ior is nan"));
  CHECK(refuses(RoughDielectricDescription{.alpha_v = -1}, "roughdielectric", "alpha_v is -1"));
  CHECK(refuses(PlasticDescription{1e12}, "plastic", "ior is 1e+12"));
  CHECK(refuses(RoughPlasticDescription{.alpha = kNaN}, "roughplastic", "alpha is nan"));
  CHECK(refuses(PrincipledDescription{.clearcoat = 2}, "principled", "clearcoat is 2"));
  CHECK(refuses(MixtureDescription{0, 0, -0.25}, "mixture", "weight is -0.25"));
  CHECK(refuses(MixtureDescription{0, 0, 0.5, -1}, "mixture", "cutoff is -1"));
}

TEST("light that is negative or no number is refused") {
  CHECK(refuses("shape 3 (rectangle)", "radiance is -1", [](SceneDescription& d) {
    std::get<RectangleDescription>(d.shapes[3]).surface.radiance = {1, -1, 1};
  }));
  CHECK(refuses("point light 1", "intensity is nan", [](SceneDescription& d) {
    d.point_lights.push_back({{0, 1, 0}, {1, kNaN, 1}});
  }));
  CHECK(refuses("spot light 2", "intensity is inf", [](SceneDescription& d) {
    d.spot_lights.push_back({{0, 1, 0}, {0, -1, 0}, {HUGE_VAL, 1, 1}});
  }));
  CHECK(refuses("directional light 2", "irradiance is -2", [](SceneDescription& d) {
    d.directional_lights.push_back({{0, 1, 0}, {-2, 0, 0}});
  }));
  CHECK(refuses("environment", "radiance is nan", [](SceneDescription& d) {
    d.environment = ConstantEnvironmentDescription{{kNaN, 0, 0}};
  }));
  CHECK(refuses("environment", "found 3 pixels", [](SceneDescription& d) {
    d.environment = ImageEnvironmentDescription{2, 2, {{}, {}, {}}, 1, {}};
  }));
  CHECK(refuses("environment", "a pixel is -1", [](SceneDescription& d) {
    d.environment = ImageEnvironmentDescription{1, 1, {{1, -1, 1}}, 1, {}};
  }));
  CHECK(refuses("group 1: shape 0 (sphere)", "radiance is -1", [](SceneDescription& d) {
    SurfaceDescription dark;
    dark.radiance = Vec3d{-1, 0, 0};
    d.groups.push_back({{SphereDescription{{}, 1, false, dark}}});
  }));
}

TEST("a shape that cannot be built is named by its place in the description, in a group too") {
  CHECK(refuses("shape 4 (sphere)", "a sphere needs a finite centre and a positive radius",
                [](SceneDescription& d) { std::get<SphereDescription>(d.shapes[4]).radius = -1; }));
  CHECK(refuses("group 0: shape 2 (disk)", "a disk needs an area", [](SceneDescription& d) {
    std::get<DiskDescription>(d.groups[0].shapes[2]).to_world = placed({0, 0, 0}, {0, 0, 0}, {0, 0, 1}, {0, 0, 0});
  }));
  CHECK(refuses("group 1: shape 1 (sphere)", "front is BSDF 99; expected an index below 9", [](SceneDescription& d) {
    d.groups.push_back({{SphereDescription{.surface = {.front = 0}}, SphereDescription{.surface = {.front = 99}}}});
  }));
  CHECK(refuses("shape 4 (sphere)", "no medium 7",
                [](SceneDescription& d) { std::get<SphereDescription>(d.shapes[4]).surface.interior = 7; }));
}

TEST("a light, a medium or a motion that cannot be is named, with what was found") {
  CHECK(refuses("point light 0", "position is not finite",
                [](SceneDescription& d) { d.point_lights[0].position.y = kNaN; }));
  CHECK(refuses("spot light 1", "beam is 50 and cutoff 40 degrees; expected 0 <= beam <= cutoff",
                [](SceneDescription& d) { d.spot_lights[1].beam_degrees = 50; }));
  CHECK(refuses("spot light 0", "direction needs a finite length above 0",
                [](SceneDescription& d) { d.spot_lights[0].direction = {}; }));
  CHECK(refuses("spot light 1", "no texture 9", [](SceneDescription& d) { d.spot_lights[1].texture = 9; }));
  CHECK(refuses("spot light 1", "u_axis needs", [](SceneDescription& d) { d.spot_lights[1].u_axis = {}; }));
  CHECK(refuses("directional light 1", "direction needs",
                [](SceneDescription& d) { d.directional_lights[1].direction.x = kNaN; }));
  CHECK(refuses("medium 2", "g is 1; expected a number above -1 and below 1",
                [](SceneDescription& d) { d.media[2].phase = {{HenyeyGreensteinDescription{1}}}; }));
  CHECK(refuses("medium 2", "the weight of a phase function is -1; expected a number from 0 to 1",
                [](SceneDescription& d) {
                  d.media[2].phase = {{RayleighDescription{}, -1}};
                }));
  CHECK(refuses("medium 0", "an albedo lies in [0, 1]; found (0.5, 2, 0.5)",
                [](SceneDescription& d) { d.media[0].albedo.y = 2; }));
  CHECK(refuses("sensor", "camera_medium is 3; expected an index below 3",
                [](SceneDescription& d) { d.camera_medium = 3; }));
  CHECK(refuses("sensor", "the times of the keys of a motion must increase", [](SceneDescription& d) {
    d.sensor_keys = {{1, placement(d.sensor)}, {0, placement(d.sensor)}};
  }));
  CHECK(refuses("shape 11 (instance)", "the keys of a motion must be finite", [](SceneDescription& d) {
    std::get<InstanceDescription>(d.shapes[11]).keys = {{0, Transform{}}, {kNaN, Transform{}}};
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
