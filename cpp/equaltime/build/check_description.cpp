#include "equaltime/build/check_description.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "equaltime/build/part_names.h"

namespace equaltime {

namespace {

/// Any finite number: whether float32 holds it is seen once the scene is normalised.
constexpr double kLargest = std::numeric_limits<double>::max();
/// Parameters of BSDFs are kept in float32 as they are.
constexpr double kLargestFloat = static_cast<double>(std::numeric_limits<float>::max());
constexpr double kSmallestFloat = static_cast<double>(std::numeric_limits<float>::min());
/// Largest index of refraction relative to the outside. Python's readers take indices from 0.001 to 1000 on both sides,
/// whose ratios reach 10^6; far beyond that, float32 loses the light.
constexpr double kHighestIor = 1e6;

/// A part of the scene whose numbers are checked, such as BSDF 3.
class Part {
 public:
  Part(std::string kind, std::size_t number) : name_(std::move(kind) + " " + std::to_string(number)) {}
  explicit Part(std::string name) : name_(std::move(name)) {}

  /// `value` must lie in [least, most].
  void number(const char* what, double value, double least, double most) const {
    if (value >= least && value <= most) return;  // never a NaN
    std::ostringstream message;
    message << what << " is " << value << "; expected a number from " << least << " to " << most;
    fail(message.str());
  }
  [[noreturn]] void fail(const std::string& problem) const { throw std::invalid_argument(name_ + ": " + problem); }
  void share(const char* what, double value) const { number(what, value, 0, 1); }
  /// Each channel must lie in [0, most].
  void color(const char* what, const Vec3d& value, double most = kLargest) const {
    for (const double channel : {value.x, value.y, value.z}) number(what, channel, 0, most);
  }
  void reflectance(const char* what, const Vec3d& value) const { color(what, value, 1); }
  void ior(double value) const { number("ior", value, 1 / kHighestIor, kHighestIor); }
  void roughness(const char* what, double value) const { number(what, value, kSmallestFloat, kLargestFloat); }

 private:
  std::string name_;
};

void check_bsdf(const Part& part, const DiffuseDescription& d) { part.reflectance("reflectance", d.reflectance); }
void check_bsdf(const Part& part, const ConductorDescription& d) {
  part.color("eta", d.eta, kLargestFloat);
  part.color("k", d.k, kLargestFloat);
  part.reflectance("specular_reflectance", d.specular_reflectance);
}
void check_bsdf(const Part& part, const RoughConductorDescription& d) {
  part.roughness("alpha_u", d.alpha_u);
  part.roughness("alpha_v", d.alpha_v);
  check_bsdf(part, ConductorDescription{d.eta, d.k, d.specular_reflectance});
}
void check_bsdf(const Part& part, const DielectricDescription& d) {
  part.ior(d.ior);
  part.reflectance("specular_reflectance", d.specular_reflectance);
  part.reflectance("specular_transmittance", d.specular_transmittance);
}
void check_bsdf(const Part& part, const ThinDielectricDescription& d) {
  check_bsdf(part, DielectricDescription{d.ior, d.specular_reflectance, d.specular_transmittance});
}
void check_bsdf(const Part& part, const RoughDielectricDescription& d) {
  part.roughness("alpha_u", d.alpha_u);
  part.roughness("alpha_v", d.alpha_v);
  check_bsdf(part, d.dielectric);
}
void check_bsdf(const Part& part, const PlasticDescription& d) {
  part.ior(d.ior);
  part.reflectance("diffuse_reflectance", d.diffuse_reflectance);
  part.reflectance("specular_reflectance", d.specular_reflectance);
}
void check_bsdf(const Part& part, const RoughPlasticDescription& d) {
  part.roughness("alpha", d.alpha);
  check_bsdf(part, d.plastic);
}
void check_bsdf(const Part& part, const PrincipledDescription& d) {
  part.reflectance("base_color", d.base_color);
  part.ior(d.ior);
  part.share("roughness", d.roughness);
  part.share("anisotropic", d.anisotropic);
  part.share("metallic", d.metallic);
  part.share("spec_trans", d.spec_trans);
  part.share("spec_tint", d.spec_tint);
  part.share("sheen", d.sheen);
  part.share("sheen_tint", d.sheen_tint);
  part.share("flatness", d.flatness);
  part.share("clearcoat", d.clearcoat);
  part.share("clearcoat_gloss", d.clearcoat_gloss);
}
void check_bsdf(const Part&, const NullDescription&) {}
void check_bsdf(const Part& part, const MixtureDescription& d) {
  part.share("weight", d.weight);
  if (d.cutoff) part.number("cutoff", *d.cutoff, 0, kLargestFloat);
}

/// The keys of whatever the part is must make a motion.
void check_motion(const Part& part, const std::vector<MotionKey>& keys) {
  if (keys.empty()) return;
  try {
    static_cast<void>(Motion(keys));
  } catch (const std::invalid_argument& wrong) {
    part.fail(wrong.what());
  }
}

/// `name` gives the name of a shape by its index.
template <class Name>
void check_shapes(const std::vector<ShapeDescription>& shapes, const Name& name) {
  for (std::size_t i = 0; i < shapes.size(); ++i)
    std::visit(
        [&](const auto& shape) {
          if constexpr (requires { shape.surface; }) {
            if (shape.surface.radiance) Part(name(i)).color("radiance", *shape.surface.radiance);
          } else if (!shape.keys.empty()) {
            check_motion(Part(name(i)), shape.keys);
          }
        },
        shapes[i]);
}

void check_lights(const SceneDescription& d) {
  for (std::size_t i = 0; i < d.point_lights.size(); ++i)
    Part("point light", i).color("intensity", d.point_lights[i].intensity);
  for (std::size_t i = 0; i < d.spot_lights.size(); ++i)
    Part("spot light", i).color("intensity", d.spot_lights[i].intensity);
  for (std::size_t i = 0; i < d.directional_lights.size(); ++i)
    Part("directional light", i).color("irradiance", d.directional_lights[i].irradiance);
  if (!d.environment) return;
  const Part part("environment");
  if (const auto* same = std::get_if<ConstantEnvironmentDescription>(&*d.environment)) {
    part.color("radiance", same->radiance);
    return;
  }
  const auto& image = *std::get_if<ImageEnvironmentDescription>(&*d.environment);
  part.number("scale", image.scale, 0, kLargest);
  const std::size_t expected = std::size_t{image.width} * image.height;
  if (image.pixels.size() != expected || expected == 0)
    part.fail("found " + std::to_string(image.pixels.size()) +
              " pixels; expected width times height = " + std::to_string(expected) + ", at least 1");
  for (const Spectrum& pixel : image.pixels) part.color("a pixel", {pixel.r, pixel.g, pixel.b});
}

void check_clips(const Part& part, const std::optional<double>& near, const std::optional<double>& far) {
  const double nearest = near.value_or(0);
  part.number("near_clip", nearest, 0, kLargest);
  if (far) part.number("far_clip", *far, std::nextafter(nearest, kLargest), HUGE_VAL);
}

void check_sensor(const SensorDescription& sensor) {
  const Part part("sensor");
  for (const auto& row : placement(sensor).m)
    for (const double entry : row) part.number("an entry of to_world", entry, -kLargest, kLargest);
  const auto* lens = std::get_if<ThinLensDescription>(&sensor);
  const auto* view = lens ? &lens->view : std::get_if<PerspectiveDescription>(&sensor);
  if (view) {
    part.number("x_fov_degrees", view->x_fov_degrees, std::numeric_limits<double>::min(), std::nextafter(180.0, 0.0));
    part.number("principal_point_x", view->principal_point_x, -kLargest, kLargest);
    part.number("principal_point_y", view->principal_point_y, -kLargest, kLargest);
    check_clips(part, view->near, view->far);
  } else {
    std::visit(
        [&](const auto& camera) {
          if constexpr (requires { camera.near; }) check_clips(part, camera.near, camera.far);
        },
        sensor);
  }
}

}  // namespace

void check(const SceneDescription& description) {
  for (std::size_t i = 0; i < description.bsdfs.size(); ++i)
    std::visit([&](const auto& d) { check_bsdf(Part(bsdf_name(description, i)), d); }, description.bsdfs[i]);
  check_shapes(description.shapes, [&](std::size_t i) { return shape_name(description.shapes, i); });
  for (std::size_t group = 0; group < description.groups.size(); ++group)
    check_shapes(description.groups[group].shapes, [&](std::size_t i) { return shape_name(description, group, i); });
  check_lights(description);
  check_sensor(description.sensor);
  check_motion(Part("sensor"), description.sensor_keys);
  if (description.camera_medium && *description.camera_medium >= description.media.size())
    Part("sensor").fail("camera_medium is " + std::to_string(*description.camera_medium) +
                        "; expected an index below " + std::to_string(description.media.size()));
}

}  // namespace equaltime
