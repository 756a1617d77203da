// The sensor of a scene, from its description to normalised space.
#pragma once

#include <optional>

#include "equaltime/build/description.h"
#include "equaltime/sensors/sensor.h"

namespace equaltime {

/// Returns the sensor of a scene; one that moves is in a space of its own. Throws std::invalid_argument for
/// numbers that make no sense, and for a camera too far away for float64.
[[nodiscard]] Sensor make_sensor(const SceneDescription& scene, const Normalization& normalization);
[[nodiscard]] std::optional<CameraMotion> make_camera_motion(const SceneDescription& scene,
                                                             const Normalization& normalization);

}  // namespace equaltime
