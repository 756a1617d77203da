// A white furnace through the installed library: inside a sphere of reflectance ρ that emits 1 - ρ, every path of at
// most N vertices brings 1 - ρ^N.
#include <equaltime/build/build_scene.h>
#include <equaltime/render/renderer.h>

#include <cmath>
#include <cstdio>
#include <memory>

int main() {
  using namespace equaltime;
  constexpr double kReflectance = 0.5;
  constexpr int kDepth = 6;

  SceneDescription description;
  description.bsdfs = {DiffuseDescription{{kReflectance, kReflectance, kReflectance}}};
  const double emitted = 1 - kReflectance;
  const SurfaceDescription wall{.front = 0, .back = {}, .radiance = Vec3d{emitted, emitted, emitted}};
  description.shapes = {SphereDescription{.center = {0, 0, 0}, .radius = 2, .flip_normals = true, .surface = wall}};
  description.film = {.width = 32, .height = 24, .crop_width = 32, .crop_height = 24};
  const auto scene = std::make_shared<const Scene>(build_scene(description));

  Settings settings;
  settings.max_depth = kDepth;
  Renderer renderer(scene, settings, RenderOptions{.seed = 1});
  renderer.advance(16);

  PixelMoments all;
  for (const PixelMoments& pixel : renderer.film().moments()) all = PixelMoments::merge(all, pixel);
  const double expected = 1 - std::pow(kReflectance, kDepth);
  const auto n = static_cast<double>(all.count);
  const double deviation = (all.mean[0] - expected) / std::sqrt(all.squares(0) / (n * (n - 1)) + 1e-14);
  std::printf("%s, %.0f samples: %.6f, expected %.6f, %.1f standard errors apart\n",
              kernel_name(renderer.kernel().effects).c_str(), n, all.mean[0], expected, deviation);
  return n == 16 * 32 * 24 && std::abs(deviation) < 5 ? 0 : 1;
}
