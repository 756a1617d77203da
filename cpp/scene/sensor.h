// Sensor: camera rays, made in float64 and advanced towards the geometry before they are rounded, so that a distant
// camera loses no digits.
#pragma once

#include "math/ray.h"
#include "scene/normalization.h"

namespace equaltime {

/// Camera space looks along +z, +x to the left of the image, +y up: Mitsuba's.
class PerspectiveCamera {
 public:
  PerspectiveCamera() = default;
  PerspectiveCamera(const PerspectiveDescription& description, const FilmDescription& film,
                    const Normalization& normalization);

  /// The ray through a place on the full film, in pixels from its upper left corner.
  [[nodiscard]] Ray ray(double x, double y) const noexcept;

 private:
  Vec3d origin_, axis_, right_, down_;  // direction = axis + x·right + y·down, x and y in pixels
  double advance_ = 0;                  // along every ray: no geometry is nearer to the camera
  double near_ = 0, far_ = 0;           // along the axis; far 0: none
};

}  // namespace equaltime
