// Sensors: camera rays, made in float64 and advanced towards the geometry before they are rounded, so that a distant
// camera loses no digits. Camera space looks along +z, +x to the left of the image, +y up: Mitsuba's. Places on the
// film are in pixels from its upper left corner.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/normalization.h"
#include "equaltime/math/point.h"
#include "equaltime/math/ray.h"
#include "equaltime/sensors/sensor_description.h"

namespace equaltime {

/// A camera ray before it is advanced and rounded. Distances along it within which geometry is seen.
struct SensorRay {
  Vec3d origin, direction;  // unit
  double near, far;         // far 0: no end
};

/// Where on the film something is seen, in pixels, and the solid angle of a pixel there.
struct FilmPoint {
  double x, y, solid_angle;
};

/// A pinhole.
class PerspectiveCamera {
 public:
  PerspectiveCamera() = default;
  /// `aperture` is how far from the pinhole rays may begin all the same.
  PerspectiveCamera(const PerspectiveDescription& description, const FilmDescription& film,
                    const Normalization& normalization, double aperture = 0);

  [[nodiscard]] Ray ray(double x, double y) const noexcept;
  [[nodiscard]] SensorRay exact(double x, double y) const noexcept;
  /// Where rays begin, and where on the film the one is that leaves it in a direction; nothing for one behind.
  [[nodiscard]] Vec3d origin() const noexcept { return origin_; }
  [[nodiscard]] std::optional<FilmPoint> place(const Vec3d& direction) const noexcept {
    return place(axis_, direction);
  }

 private:
  friend class ThinLensCamera;
  /// The same from a point of a lens, by which the axis is another.
  [[nodiscard]] std::optional<FilmPoint> place(const Vec3d& axis, const Vec3d& direction) const noexcept;

  Vec3d origin_, axis_, right_, down_;  // direction = axis + x·right + y·down, x and y in pixels
  double advance_ = 0;                  // along every ray: no geometry is nearer to the camera
  double near_ = 0, far_ = 0;           // along the axis; far 0: none
};

/// A lens without thickness: rays begin anywhere on its disk, or on the polygon that blades leave of it, and meet, for
/// one place on the film, in the plane of focus.
class ThinLensCamera {
 public:
  ThinLensCamera(const ThinLensDescription& description, const FilmDescription& film,
                 const Normalization& normalization);

  [[nodiscard]] Ray ray(double x, double y, Point2f lens) const noexcept;
  [[nodiscard]] SensorRay exact(double x, double y, Point2f lens) const noexcept;
  /// As a pinhole's, of a point of the lens.
  [[nodiscard]] Vec3d origin(Point2f lens) const noexcept { return view_.origin_ + on_lens(lens); }
  [[nodiscard]] std::optional<FilmPoint> place(const Vec3d& direction, Point2f lens) const noexcept {
    return view_.place(view_.axis_ - on_lens(lens) / focus_, direction);
  }

 private:
  /// From the middle of the lens.
  [[nodiscard]] Vec3d on_lens(Point2f lens) const noexcept;

  PerspectiveCamera view_;
  Vec3d lens_x_, lens_y_;  // radii of the lens
  double focus_;           // distance of the plane of focus
  std::uint32_t blades_;   // 0: a disk
  float rotation_;         // of the polygon, in radians
};

/// Parallel rays.
class OrthographicCamera {
 public:
  OrthographicCamera(const OrthographicDescription& description, const FilmDescription& film,
                     const Normalization& normalization);

  [[nodiscard]] Ray ray(double x, double y) const noexcept;
  [[nodiscard]] SensorRay exact(double x, double y) const noexcept;

 private:
  Vec3d corner_, right_, down_;  // of the film, and one pixel
  Vec3d direction_;              // unit
  Vec3d first_;                  // no geometry is before the plane through this point, across the direction
  double slack_ = 0;             // for the rounding of that
  double near_ = 0, far_;        // along every ray
};

/// All directions, equal angles apart.
class SphericalCamera {
 public:
  SphericalCamera(const SphericalDescription& description, const FilmDescription& film,
                  const Normalization& normalization);

  [[nodiscard]] Ray ray(double x, double y) const noexcept;
  [[nodiscard]] SensorRay exact(double x, double y) const noexcept;

 private:
  Vec3d origin_, x_axis_, y_axis_, z_axis_;
  double azimuth_, polar_;  // of a pixel, in radians
  double near_;
  double start_;  // of every ray: the near clip, or before the geometry
  double far_;    // infinite: none
};

using Sensor = std::variant<PerspectiveCamera, ThinLensCamera, OrthographicCamera, SphericalCamera>;

/// Takes the rays of a sensor that was made in the camera's own space to where the camera is at a time.
class CameraMotion {
 public:
  /// Throws std::invalid_argument for keys that make no motion.
  CameraMotion(const std::vector<MotionKey>& keys, const Normalization& normalization);

  [[nodiscard]] Ray ray(const Sensor& sensor, double x, double y, Point2f lens, float time) const noexcept;
  /// Where the camera is.
  [[nodiscard]] Vec3d place(float time) const noexcept { return to_world_.at(static_cast<double>(time)).origin; }
  /// The box around all the places where it is.
  [[nodiscard]] Bounds places() const noexcept { return to_world_.swept({{}, {}}); }

 private:
  Motion to_world_;
  Bounds bounds_;  // of the geometry
};

/// The ray through a place on the film, at a time from 0 to 1 if the camera moves. `lens` gives two uniform numbers,
/// and is called only where there is a lens.
template <Effects E, class LensNumbers>
[[nodiscard]] EQUALTIME_INLINE Ray camera_ray(const Sensor& sensor,
                                              [[maybe_unused]] const std::optional<CameraMotion>& motion, double x,
                                              double y, LensNumbers&& lens, [[maybe_unused]] float time) noexcept {
  if constexpr (E.motion) {
    if (motion) {
      const bool has_lens = std::holds_alternative<ThinLensCamera>(sensor);
      return motion->ray(sensor, x, y, has_lens ? lens() : Point2f{}, time);
    }
  }
  if constexpr (E.lens) {
    if (const auto* thin = std::get_if<ThinLensCamera>(&sensor)) return thin->ray(x, y, lens());
    if (const auto* parallel = std::get_if<OrthographicCamera>(&sensor)) return parallel->ray(x, y);
    if (const auto* spherical = std::get_if<SphericalCamera>(&sensor)) return spherical->ray(x, y);
  }
  return std::get_if<PerspectiveCamera>(&sensor)->ray(x, y);
}

}  // namespace equaltime
