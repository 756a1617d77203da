// MovingLights: the area lights of one shape that moves, as they are in its own space, and where they are at a time.
#pragma once

#include <vector>

#include "equaltime/base/type_list.h"
#include "equaltime/lights/cylinder_light.h"
#include "equaltime/lights/disk_light.h"
#include "equaltime/lights/sphere_light.h"
#include "equaltime/lights/textured_area_light.h"
#include "equaltime/math/motion.h"
#include "equaltime/scene/instance.h"

namespace equaltime {

using AreaLights = TypeList<TriangleLight<float>, SphereLight, DiskLight, CylinderLight, TexturedRectangle,
                            TexturedTriangle, RectangleLight<float>>;
using AreaLight = AreaLights::Variant;

struct MovingLights {
  std::uint32_t first;           // number of the first of these lights; the others follow
  std::vector<AreaLight> local;  // in the instance's space; no rectangles: motion may make parallelograms of them
  MovingInstanceGeometry instance;

  /// Shutter time at which light selection sees a moving light: it does not know the time of a path.
  static constexpr float kReferenceTime = 0.5F;

  [[nodiscard]] bool has(std::uint32_t light) const noexcept { return light - first < local.size(); }
  [[nodiscard]] AreaLight at(std::uint32_t light, float time) const noexcept;
  /// The sample with its offset enlarged for the error of a moving instance's transform.
  [[nodiscard]] Optional<LightSample<float>> with_offset(Optional<LightSample<float>> sample,
                                                         float time) const noexcept;
  /// Bounds of a light over the whole shutter.
  [[nodiscard]] LightBounds bounds(std::uint32_t light) const noexcept;
};

/// Returns the lights from index `begin` on in the local space of a moving instance. `lights` keeps them in world
/// space, as they are at `kReferenceTime`.
[[nodiscard]] MovingLights moving_lights(std::vector<AreaLight>& lights, std::size_t begin,
                                         MovingInstanceGeometry instance);

}  // namespace equaltime
