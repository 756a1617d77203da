// A white furnace through the installed library: inside a sphere of reflectance ρ that emits 1 - ρ, every path of at
// most N vertices brings 1 - ρ^N. A second thread could end the render by `stop`.
#include <equaltime/equaltime.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <stop_token>

int main() {
  using namespace equaltime;
  constexpr double kReflectance = 0.5, kEmitted = 1 - kReflectance;
  constexpr int kDepth = 6;
  constexpr std::uint64_t kSamples = 16;

  const SceneDescription description{
      .bsdfs = {DiffuseDescription{.reflectance = {kReflectance, kReflectance, kReflectance}}},
      .shapes = {SphereDescription{.center = {0, 0, 0},
                                   .radius = 2,
                                   .flip_normals = true,
                                   .surface = {.front = 0, .radiance = Vec3d{kEmitted, kEmitted, kEmitted}}}},
      .film = {.width = 32, .height = 24, .crop_width = 32, .crop_height = 24},
  };
  const auto scene = std::make_shared<const Scene>(build_scene(description, {.threads = 2}));

  Renderer renderer(scene, Settings{.max_depth = kDepth}, RenderOptions{.seed = 1});
  const std::stop_source stop;
  const bool complete = renderer.advance(kSamples, stop.get_token());

  // Pixels are independent: their spread gives the standard error of the image's mean.
  const Film& film = renderer.film();
  const double pixels = static_cast<double>(film.width()) * film.height();
  double sum = 0, squares = 0;
  for (std::uint32_t y = 0; y < film.height(); ++y)
    for (std::uint32_t x = 0; x < film.width(); ++x) {
      const auto [red, green, blue] = film.mean(x, y);
      sum += red;
      squares += red * red;
    }
  const double mean = sum / pixels, expected = 1 - std::pow(kReflectance, kDepth);
  const double variance = std::fmax(squares / pixels - mean * mean, 0) / (pixels - 1);
  const double deviation = (mean - expected) / std::sqrt(variance + 1e-14);
  std::printf("%s, %.0f pixels of %llu samples: %.6f, expected %.6f, %.1f standard errors apart\n",
              kernel_name(renderer.kernel().effects).c_str(), pixels,
              static_cast<unsigned long long>(renderer.position().done), mean, expected, deviation);
  return complete && std::abs(deviation) < 5 ? 0 : 1;
}
