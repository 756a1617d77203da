// Small scenes for tests of the whole renderer, and a digest of what it made of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "equaltime/build/build_scene.h"
#include "equaltime/render/renderer.h"

namespace scenes {

using namespace equaltime;

inline Transform placed(const Vec3d& x, const Vec3d& y, const Vec3d& z, const Vec3d& at) {
  return {{{{x.x, y.x, z.x, at.x}, {x.y, y.y, z.y, at.y}, {x.z, y.z, z.z, at.z}, {0, 0, 0, 1}}}};
}

/// A room of two diffuse walls and a floor under one rectangular light: the cheapest kernel renders it.
inline SceneDescription room() {
  SceneDescription d;
  d.bsdfs = {DiffuseDescription{{0.7, 0.6, 0.5}}, DiffuseDescription{{0.1, 0.5, 0.2}}};
  const SurfaceDescription grey{0, 0, {}}, green{1, 1, {}}, emitter{0, {}, Vec3d{17, 12, 4}};
  d.shapes = {
      RectangleDescription{placed({1, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 0, 0}), false, grey},
      RectangleDescription{placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 1, -1}), false, grey},
      RectangleDescription{placed({0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {1, 1, 0}), false, green},
      RectangleDescription{placed({0.3, 0, 0}, {0, 0, 0.2}, {0, -1, 0}, {0, 1.9, 0}), false, emitter},
  };
  d.sensor = PerspectiveDescription{placed({-1, 0, 0}, {0, 1, 0}, {0, 0, -1}, {-0.125, 1, 4}), 33, {}, {}};
  d.film = {33, 26, 0, 0, 33, 26, FilterKind::tent, 1};
  return d;
}

/// The room with a sphere, a disk and a cylinder of its own grey.
inline SceneDescription room_of_curves() {
  SceneDescription d = room();
  d.shapes.emplace_back(SphereDescription{{-0.5, 0.25, 0}, 0.25, false, {0, {}, {}}});
  d.shapes.emplace_back(
      DiskDescription{placed({0.25, 0, 0}, {0, 0.25, 0}, {0, 0, 1}, {0.25, 0.5, -0.5}), false, {0, 1, {}}});
  d.shapes.emplace_back(CylinderDescription{{0.5, 0, 0}, {0.5, 0.75, 0}, 0.125, false, {1, 0, {}}});
  return d;
}

/// The room with everything that the renderer knows in it.
inline SceneDescription full_room() {
  SceneDescription d = room();
  const Vec3d eta{0.2, 0.9, 1.1}, k{3.9, 2.5, 2.1}, white{1, 1, 1};
  d.bsdfs.emplace_back(RoughConductorDescription{MicrofacetModel::ggx, 0.2, 0.1, eta, k, white});
  d.bsdfs.emplace_back(RoughConductorDescription{MicrofacetModel::beckmann, 0.3, 0.3, eta, k, white});
  d.bsdfs.emplace_back(ConductorDescription{eta, k, white});
  d.bsdfs.emplace_back(DielectricDescription{});
  const double s = 0.25;
  d.shapes.emplace_back(SphereDescription{{-0.5, s, 0}, s, false, {5, 5, {}}});
  d.shapes.emplace_back(SphereDescription{{0.5, s, 0.25}, s, false, {4, {}, {}}});
  d.shapes.emplace_back(SphereDescription{{0, 1.5, 0}, 0.0625, false, {0, {}, Vec3d{1, 2, 3}}});
  d.shapes.emplace_back(
      DiskDescription{placed({s, 0, 0}, {0, s, 0}, {0, 0, 1}, {0.25, 0.5, -0.5}), false, {2, 3, Vec3d{0.5, 0.5, 1}}});
  d.shapes.emplace_back(CylinderDescription{{-0.75, 0.25, 0.5}, {-0.5, 1, 0.25}, 0.125, false, {1, 0, {}}});
  d.shapes.emplace_back(CylinderDescription{{0.5, 1, 0}, {0.75, 1.25, 0}, 0.0625, true, {0, 1, Vec3d{0.5, 1, 0.5}}});
  MeshDescription pyramid;  // smooth normals over four triangles, one of them without a BSDF of its own side
  pyramid.vertices = {{-0.25, 0, 0.5}, {0.25, 0, 0.5}, {0, 0, 0}, {0, 0.5, 0.25}};
  pyramid.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
  pyramid.normals = {{-1, 0, 1}, {1, 0, 1}, {0, 0, -1}, {0, 1, 0}};
  pyramid.surface = {2, 0, {}};
  d.shapes.emplace_back(pyramid);
  GroupDescription group;  // one of each, seen small and skewed, and turned over
  group.shapes.emplace_back(pyramid);
  group.shapes.emplace_back(SphereDescription{{0.5, 0, 0}, 0.25, false, {2, 3, {}}});
  group.shapes.emplace_back(
      DiskDescription{placed({s, 0, 0}, {0, s, 0}, {0, 0, 1}, {-0.5, 0.5, 0}), false, {0, 0, {}}});
  group.shapes.emplace_back(CylinderDescription{{0, -0.5, 0}, {0.25, -0.25, 0.25}, 0.125, false, {5, 5, {}}});
  d.groups.push_back(group);
  d.shapes.emplace_back(InstanceDescription{0, placed({0.25, 0, 0}, {0, 0.5, 0.125}, {0.125, 0, 0.25}, {0.5, 1, 0})});
  d.shapes.emplace_back(InstanceDescription{0, placed({-0.25, 0, 0}, {0, 0.25, 0}, {0, 0, 0.5}, {-0.5, 1.25, 0.25})});
  d.point_lights = {{{-0.75, 1.5, 0.5}, {2, 1, 0.5}}};
  d.spot_lights = {{{0.5, 1.75, 0.75}, {-0.5, -1.5, -0.5}, {1, 2, 3}, 25, 10}};
  d.spot_lights.push_back({{-0.5, 1.75, 0.5}, {0, -1, 0}, {2, 1, 1}, 40, 30, 0, {1, 0, 0}, {0, 0, 1}});
  d.directional_lights = {{{0.25, -1, -0.5}, {0.25, 0.125, 0.5}}, {{0, 0, -1}, {0.125, 0.125, 0}}};
  ImageEnvironmentDescription sky;
  sky.width = 8, sky.height = 5;
  for (int i = 0; i < 40; ++i) {
    const auto x = static_cast<float>(i % 7);
    sky.pixels.emplace_back(0.125F * x, 0.25F, i == 19 ? 40.0F : 0.5F);
  }
  d.environment = sky;
  BitmapDescription bitmap;  // of three texels, grey
  bitmap.width = 3, bitmap.channels = 1, bitmap.format = TexelFormat::u8;
  bitmap.texels = {std::byte{10}, std::byte{200}, std::byte{90}};
  d.textures = {CheckerboardDescription{{0.1, 0.5, 0.2}, {0.6, 0.1, 0.1}, {4, 0, 0, 0, 4, 0}}, bitmap};
  d.bindings = {{1, "reflectance", 0}, {3, "alpha", 1}};
  d.bsdfs.emplace_back(NullDescription{});
  const auto nothing = static_cast<std::uint32_t>(d.bsdfs.size() - 1);
  d.bsdfs.emplace_back(MixtureDescription{nothing, 0, 0.5});
  d.bindings.push_back({nothing + 1, "weight", 0});
  d.shapes.emplace_back(SphereDescription{{-0.25, 1.25, 0.5}, 0.125, false, {nothing + 1, nothing + 1, {}}});
  d.bsdfs.emplace_back(DiffuseDescription{{0.3, 0.6, 0.6}});
  d.normal_maps = {{nothing + 2, 1, true, 0.05}};
  d.shapes.emplace_back(
      RectangleDescription{placed({s, 0, 0}, {0, s, 0}, {0, 0, 1}, {-0.5, 1, -0.75}), false, {nothing + 2, {}, {}}});
  // Haze everywhere, a drop of milk in nothing's skin and one of ink in glass.
  using Hg = HenyeyGreensteinDescription;
  d.media = {{{0.125, 0.125, 0.25}, {0.5, 0.75, 0.5}, {{Hg{0.5}}}},
             {{8, 4, 2}, {0.9, 0.8, 0.7}, {{Hg{0.5}, 0.25}, {RayleighDescription{}, 0.5}, {Hg{-0.25}, 0.25}}},
             {{4, 2, 8}, {}}};
  d.shapes.emplace_back(SphereDescription{{0, 0.75, 0.75}, 0.25, false, {nothing, nothing, {}, 0, 1}});
  d.shapes.emplace_back(SphereDescription{{-0.5, 0.75, 0.75}, 0.125, false, {5, 5, {}, 0, 2}});
  d.camera_medium = 0;
  return d;
}

/// A quarter turn about the y axis, and where it goes, in four keys of which two are while the shutter is open.
inline std::vector<MotionKey> swing(const Vec3d& from, const Vec3d& to, double size) {
  std::vector<MotionKey> keys;
  for (const auto& [time, c, s] : {std::array{-0.5, 1.0, 0.0}, {0.25, 0.8, 0.6}, {0.75, 0.28, 0.96}, {1.5, 0.0, 1.0}})
    keys.push_back({time, placed({size * c, 0, -size * s}, {0, size * (1 + s / 4), 0}, {size * s, 0, size * c},
                                 from * (1 - s) + to * s)});
  return keys;
}

/// Adds an emitter, a ball and two walls that swing through the scene while the camera moves.
inline SceneDescription in_motion(SceneDescription d) {
  const SurfaceDescription emitter{0, {}, Vec3d{2, 4, 8}}, green{1, 1, {}};
  GroupDescription shining, box;
  shining.shapes.emplace_back(
      RectangleDescription{placed({1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {0, 1, 0}), false, emitter});
  box.shapes.emplace_back(RectangleDescription{placed({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 1}), false, green});
  box.shapes.emplace_back(RectangleDescription{placed({0, 0, -1}, {0, 1, 0}, {1, 0, 0}, {1, 0, 0}), false, green});
  const auto first = static_cast<std::uint32_t>(d.groups.size());
  d.groups.push_back(shining);
  d.groups.push_back(box);
  d.shapes.emplace_back(InstanceDescription{first, {}, swing({-0.5, 1.25, 0}, {0.25, 1, 0.5}, 0.125)});
  d.shapes.emplace_back(InstanceDescription{first + 1, {}, swing({0.5, 0.25, 0.5}, {-0.5, 0.5, 0.25}, 0.25)});
  d.sensor_keys = {{0, placement(d.sensor)}, {1, placement(d.sensor)}};
  for (std::size_t row = 0; row < 3; ++row) d.sensor_keys[1].to_world.m[row][3] += 0.125;
  return d;
}

/// The same without its media.
inline SceneDescription in_vacuum(SceneDescription d) {
  for (MediumDescription& medium : d.media) medium.sigma_t = {0, 0, 0};
  return d;
}

/// Without the camera seeing what shines.
inline SceneDescription hiding(SceneDescription d) {
  d.hides_emitters = true;
  return d;
}

inline PerspectiveDescription& view_of(SceneDescription& d) { return std::get<PerspectiveDescription>(d.sensor); }

/// Seen through a lens that is as large as an emitter.
inline SceneDescription through_a_lens(SceneDescription d) {
  d.sensor = ThinLensDescription{view_of(d), 0.25, 3.5};
  return d;
}

/// Seen from infinitely far away, clipped.
inline SceneDescription from_afar(SceneDescription d) {
  d.sensor = OrthographicDescription{placed({-1.25, 0, 0}, {0, 1.25, 0}, {0, 0, -1.25}, {-0.125, 1, 4}), 2.75, 4.0};
  return d;
}

inline std::shared_ptr<const Scene> built(SceneDescription description) {
  return std::make_shared<const Scene>(build_scene(std::move(description)));
}

/// The same lengths in a unit s times as small: what was 1 is s now, and nothing looks different.
inline SceneDescription with_lengths(SceneDescription d, double s) {
  const auto scale = [s](Transform& t, std::size_t columns) {
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 4 - columns; column < 4; ++column) t.m[row][column] *= s;
  };
  const auto scale_shape = [&](ShapeDescription& shape) {
    if (auto* mesh = std::get_if<MeshDescription>(&shape))
      for (Vec3d& v : mesh->vertices) v = v * s;
    if (auto* rectangle = std::get_if<RectangleDescription>(&shape)) scale(rectangle->to_world, 4);
    if (auto* disk = std::get_if<DiskDescription>(&shape)) scale(disk->to_world, 4);
    if (auto* sphere = std::get_if<SphereDescription>(&shape)) sphere->center = sphere->center * s, sphere->radius *= s;
    if (auto* tube = std::get_if<CylinderDescription>(&shape))
      tube->base = tube->base * s, tube->end = tube->end * s, tube->radius *= s;
    if (auto* instance = std::get_if<InstanceDescription>(&shape)) {
      scale(instance->to_world, 1);
      for (MotionKey& key : instance->keys) scale(key.to_world, 1);
    }
  };
  std::for_each(d.shapes.begin(), d.shapes.end(), scale_shape);
  for (GroupDescription& group : d.groups) std::for_each(group.shapes.begin(), group.shapes.end(), scale_shape);
  for (NormalMapDescription& map : d.normal_maps) map.scale *= s;
  for (MediumDescription& medium : d.media) medium.sigma_t = medium.sigma_t / s;
  for (PointLightDescription& light : d.point_lights)
    light.position = light.position * s, light.intensity = light.intensity * (s * s);
  for (SpotLightDescription& light : d.spot_lights)
    light.position = light.position * s, light.intensity = light.intensity * (s * s);
  const auto scale_view = [&](PerspectiveDescription& view) {
    scale(view.to_world, 1);
    for (auto* clip : {&view.near, &view.far})
      if (*clip) **clip *= s;
  };
  if (auto* view = std::get_if<PerspectiveDescription>(&d.sensor)) scale_view(*view);
  if (auto* lens = std::get_if<ThinLensDescription>(&d.sensor)) {
    scale_view(lens->view);
    lens->aperture_radius *= s, lens->focus_distance *= s;
  }
  auto* parallel = std::get_if<OrthographicDescription>(&d.sensor);
  if (parallel != nullptr) scale(parallel->to_world, 4);
  for (MotionKey& key : d.sensor_keys) scale(key.to_world, parallel != nullptr ? 4 : 1);
  return d;
}

/// Every light s times as bright.
inline SceneDescription with_light(SceneDescription d, double s) {
  for (ShapeDescription& shape : d.shapes)
    std::visit(
        [s](auto& any) {
          if constexpr (requires { any.surface; })
            if (any.surface.radiance) any.surface.radiance = *any.surface.radiance * s;
        },
        shape);
  for (GroupDescription& group : d.groups)
    for (ShapeDescription& shape : group.shapes)
      if (auto* emitter = std::get_if<RectangleDescription>(&shape); emitter != nullptr && emitter->surface.radiance)
        emitter->surface.radiance = *emitter->surface.radiance * s;
  for (PointLightDescription& light : d.point_lights) light.intensity = light.intensity * s;
  for (SpotLightDescription& light : d.spot_lights) light.intensity = light.intensity * s;
  for (DirectionalLightDescription& light : d.directional_lights) light.irradiance = light.irradiance * s;
  if (d.environment) {
    if (auto* constant = std::get_if<ConstantEnvironmentDescription>(&*d.environment))
      constant->radiance = constant->radiance * s;
    else
      std::get<ImageEnvironmentDescription>(*d.environment).scale *= s;
  }
  return d;
}

using Moments = std::vector<PixelMoments>;

/// Equal in every bit: counts, means, squared deviations.
inline bool same_bits(const Moments& a, const Moments& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(PixelMoments)) == 0;
}

inline Moments rendered(const std::shared_ptr<const Scene>& scene, std::uint64_t samples, const Settings& settings = {},
                        const RenderOptions& options = {.threads = 2}) {
  Renderer renderer(scene, settings, options);
  renderer.advance(samples);
  return renderer.film().moments();
}

/// The mean over pixels, replicates and channels: that something was seen at all.
inline double mean(const Moments& moments) {
  double sum = 0;
  for (const PixelMoments& m : moments) sum += m.mean[0] + m.mean[1] + m.mean[2];
  return sum / (3 * static_cast<double>(moments.size()));
}

}  // namespace scenes
