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

/// A part of the scene whose numbers are checked, such as BSDF 3.
class Part {
 public:
  Part(std::string kind, std::size_t number) : name_(std::move(kind) + " " + std::to_string(number)) {}
  explicit Part(std::string name) : name_(std::move(name)) {}

  void number(const char* what, double value, const Range& range) const {
    const auto& [least, most, open] = range;
    if (open ? value > least && value < most : value >= least && value <= most) return;  // false for NaN
    std::ostringstream message;
    message << what << " is " << value << "; expected a number " << (open ? "above " : "from ") << least
            << (open ? " and below " : " to ") << most;
    fail(message.str());
  }
  /// `value` must lie in [least, most].
  void number(const char* what, double value, double least, double most) const {
    number(what, value, Range{least, most});
  }
  [[noreturn]] void fail(const std::string& problem) const { throw std::invalid_argument(name_ + ": " + problem); }
  void fraction(const char* what, double value) const { number(what, value, 0, 1); }
  /// Each channel must lie in [0, most].
  void color(const char* what, const Vec3d& value, double most = kLargest) const {
    for (const double channel : {value.x, value.y, value.z}) number(what, channel, 0, most);
  }

 private:
  std::string name_;
};

/// Each number in its range, and each channel of a colour; and what only the model knows.
template <class Model>
void check_fields(const Part& part, const typename Model::Description& d) {
  for_each_of(Model::fields(), [&](const auto& field, std::size_t) {
    const auto& value = d.*field.value;
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, double>) part.number(field.name, value, field.range);
    if constexpr (std::is_same_v<Value, Vec3d>)
      for (const double channel : {value.x, value.y, value.z}) part.number(field.name, channel, field.range);
    if constexpr (std::is_same_v<Value, std::vector<double>>)
      for (const double entry : value) part.number(field.name, entry, field.range);
  });
  if constexpr (requires { Model::problem(d); })
    if (const char* problem = Model::problem(d)) part.fail(problem);
}
void check_mixture(const Part& part, const MixtureDescription& d) {
  part.fraction("weight", d.weight);
  if (d.cutoff) part.number("cutoff", *d.cutoff, 0, kCoefficient.most);
}

void check_phase(const Part& part, const MediumDescription& medium) {
  for (const PhaseLobeDescription& lobe : medium.phase) {
    part.fraction("the weight of a phase function", lobe.weight);
    PhaseLobes::for_each([&]<class Model>(std::type_identity<Model>) {
      if (const auto* d = std::get_if<typename Model::Description>(&lobe.law)) check_fields<Model>(part, *d);
    });
  }
}

/// Fails if the keys make no motion.
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
  for (std::size_t i = 0; i < description.bsdfs.size(); ++i) {
    const Part part(bsdf_name(description, i));
    const BsdfDescription& bsdf = description.bsdfs[i];
    if (const auto* mixture = std::get_if<MixtureDescription>(&bsdf)) check_mixture(part, *mixture);
    Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
      if (const auto* d = std::get_if<typename Model::Description>(&bsdf)) check_fields<Model>(part, *d);
    });
  }
  check_shapes(description.shapes, [&](std::size_t i) { return shape_name(description.shapes, i); });
  for (std::size_t group = 0; group < description.groups.size(); ++group)
    check_shapes(description.groups[group].shapes, [&](std::size_t i) { return shape_name(description, group, i); });
  for (std::size_t i = 0; i < description.media.size(); ++i) check_phase(Part("medium", i), description.media[i]);
  check_lights(description);
  check_sensor(description.sensor);
  check_motion(Part("sensor"), description.sensor_keys);
  if (description.camera_medium && *description.camera_medium >= description.media.size())
    Part("sensor").fail("camera_medium is " + std::to_string(*description.camera_medium) +
                        "; expected an index below " + std::to_string(description.media.size()));
}

}  // namespace equaltime
