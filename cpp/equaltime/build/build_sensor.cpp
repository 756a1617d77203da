#include "equaltime/build/build_sensor.h"

#include <cmath>
#include <stdexcept>

namespace equaltime {

namespace {

/// In normalised space, whose extent is near 2^10.
constexpr double kWidestLens = 0x1p30;
/// Over the radius of the lens.
constexpr double kNearestFocus = 1e-6;

Sensor sensor_of(const SensorDescription& description, const FilmDescription& film,
                 const Normalization& normalization) {
  if (const auto* lens = std::get_if<ThinLensDescription>(&description)) {
    if (lens->aperture_radius == 0) return PerspectiveCamera(lens->view, film, normalization);
    if (!(lens->aperture_radius > 0 && std::isfinite(lens->aperture_radius)))
      throw std::invalid_argument("a lens needs a finite radius that is not negative");
    if (!(lens->focus_distance > 0 && std::isfinite(lens->focus_distance)))
      throw std::invalid_argument("a lens needs a finite, positive focus distance");
    // Beyond, rays would start and point where single precision has no numbers, which Embree answers with an abort.
    if (!(normalization.length(lens->aperture_radius) < kWidestLens))
      throw std::invalid_argument("a lens needs a radius below a million times the size of the scene");
    if (!(lens->focus_distance > kNearestFocus * lens->aperture_radius))
      throw std::invalid_argument("a lens needs a focus distance above a millionth of its radius");
    if (lens->blades == 1 || lens->blades == 2)
      throw std::invalid_argument("a lens has no blades, or three at the least");
    if (!std::isfinite(lens->rotation_degrees)) throw std::invalid_argument("a lens needs a finite rotation");
    return ThinLensCamera(*lens, film, normalization);
  }
  if (const auto* parallel = std::get_if<OrthographicDescription>(&description))
    return OrthographicCamera(*parallel, film, normalization);
  if (const auto* spherical = std::get_if<SphericalDescription>(&description))
    return SphericalCamera(*spherical, film, normalization);
  return PerspectiveCamera(*std::get_if<PerspectiveDescription>(&description), film, normalization);
}

}  // namespace

Sensor make_sensor(const SceneDescription& scene, const Normalization& normalization) {
  if (scene.sensor_keys.empty()) return sensor_of(scene.sensor, scene.film, normalization);
  SensorDescription own = scene.sensor;
  place(own, {});
  return sensor_of(own, scene.film, normalization.of_camera());
}

std::optional<CameraMotion> make_camera_motion(const SceneDescription& scene, const Normalization& normalization) {
  if (scene.sensor_keys.empty()) return std::nullopt;
  return CameraMotion(scene.sensor_keys, normalization);
}

}  // namespace equaltime
