// SceneDescription: a scene as plain data, in world space, in the units of its author, in float64.
// It is what a reader fills in and what `build_scene` compiles; it knows nothing of how scenes are rendered.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "equaltime/bsdfs/bsdf.h"
#include "equaltime/lights/environment.h"
#include "equaltime/math/motion.h"
#include "equaltime/math/transform.h"
#include "equaltime/math/vector.h"
#include "equaltime/media/phase_function.h"
#include "equaltime/sensors/sensor_description.h"
#include "equaltime/textures/texture_description.h"

namespace equaltime {

// --- BSDFs: one-sided leaves; shapes say which one stands on which side -------------------------------------------

/// Nothing: light passes straight on.
struct NullDescription {};
/// At each point one of two at random: `second` with the probability `weight`. A mask is nothing and what it hides.
struct MixtureDescription {
  std::uint32_t first, second;        // indices into SceneDescription::bsdfs, before this one
  double weight = 0.5;                // in [0, 1]
  std::optional<double> cutoff = {};  // makes the weight 1 where it is at least this, else 0
};
namespace detail {
/// The descriptions of a list of models, and others.
template <class Models, class... Others>
struct DescriptionsOf;
template <class... Models, class... Others>
struct DescriptionsOf<TypeList<Models...>, Others...> {
  using Variant = std::variant<typename Models::Description..., Others...>;
};
}  // namespace detail

using BsdfDescription = detail::DescriptionsOf<Bsdfs, NullDescription, MixtureDescription>::Variant;

// --- Textures of BSDFs --------------------------------------------------------------------------------------------

/// A parameter of a BSDF that a texture gives, in place of the constant in the BSDF's own description.
struct TextureBinding {
  std::uint32_t bsdf;
  std::string parameter;  // "weight" of a mixture, or as the model has it in `textured`
  std::uint32_t texture;
  std::optional<std::uint32_t> times = {};  // another texture that multiplies it
};

/// A texture changes the shading normal of a BSDF that is no mixture. A bump map is a height, in the author's units of
/// length. A normal map is (n + 1) / 2 in the frame whose first axis follows u.
struct NormalMapDescription {
  std::uint32_t bsdf, texture;
  bool bump = false;
  double scale = 1;          // of a height
  bool flip_invalid = true;  // a perturbed normal that faces away from the viewer is reflected about the shading normal
  bool shadowing = true;     // by Conty Estevez et al. (2019), "A Microfacet-Based Shadowing Function"
  bool negate_back = false;  // on a back side, the normal is the front's negated, not its mirror image
};

// --- Media --------------------------------------------------------------------------------------------------------

using PhaseDescription = detail::DescriptionsOf<PhaseLobes>::Variant;
/// A part of a medium's phase function.
struct PhaseLobeDescription {
  PhaseDescription law;
  double weight = 1;  // over the sum of all
};
/// A homogeneous medium. Its phase function is isotropic unless `phase` says otherwise.
struct MediumDescription {
  Vec3d sigma_t{1, 1, 1};                        // extinction per unit of length; where there is none, vacuum
  Vec3d albedo{0.75, 0.75, 0.75};                // the part of it that is scattering
  std::vector<PhaseLobeDescription> phase = {};  // at most 8 laws that differ
};

// --- Shapes -------------------------------------------------------------------------------------------------------

/// Surface properties of every shape. A side without a BSDF absorbs all light. Only the front side emits.
struct SurfaceDescription {
  std::optional<std::uint32_t> front = {}, back = {};  // indices into SceneDescription::bsdfs
  std::optional<Vec3d> radiance = {};
  std::optional<std::uint32_t> exterior = {}, interior = {};  // into its media: what is before the front, and behind
  std::optional<int> priority = {};  // of the interior: where such shapes overlap, the highest priority fills the space
  std::optional<std::uint32_t> emission = {};  // index of a texture that multiplies the radiance
};
struct MeshDescription {
  static constexpr const char* name = "mesh";
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from the front
  std::vector<Vec3d> normals = {};                      // one a vertex, or none
  std::vector<std::array<double, 2>> uvs = {};          // one a vertex, or none
  std::vector<AttributeValues> attributes = {};
  SurfaceDescription surface = {};
  /// Where the vertices are later, at evenly spaced times up to 1, if they move, and their normals, if there are any.
  std::vector<std::vector<Vec3d>> later_vertices = {}, later_normals = {};
};
struct RectangleDescription {  // the image of [-1, 1]² under to_world, front towards +z
  static constexpr const char* name = "rectangle";
  Transform to_world = {};
  bool flip_normals = false;
  SurfaceDescription surface = {};
};
struct DiskDescription {  // the image of the unit disk under to_world, front towards +z
  static constexpr const char* name = "disk";
  Transform to_world = {};
  bool flip_normals = false;
  SurfaceDescription surface = {};
};
struct SphereDescription {
  static constexpr const char* name = "sphere";
  Vec3d center = {};
  double radius = 1;
  bool flip_normals = false;
  SurfaceDescription surface = {};
  Vec3d pole{0, 0, 1};      // the axis round which azimuth is counted
  Vec3d meridian{1, 0, 0};  // where azimuth is 0
  bool mirrored = false;    // azimuth runs the other way round
};
struct CylinderDescription {  // a tube without caps, front outwards
  static constexpr const char* name = "cylinder";
  Vec3d base, end;  // of its axis
  double radius = 1;
  bool flip_normals = false;
  SurfaceDescription surface = {};
  Vec3d meridian{1, 0, 0};  // where azimuth is 0
  bool mirrored = false;    // azimuth runs the other way round
};
/// A group of shapes, once more: to_world takes its space to the scene's. Keys, if there are any, stand for it and make
/// it move; what is the only instance of its group, and has keys, may emit.
struct InstanceDescription {
  static constexpr const char* name = "instance";
  std::uint32_t group = 0;
  Transform to_world = {};
  std::vector<MotionKey> keys = {};
};
using ShapeDescriptions = TypeList<MeshDescription, RectangleDescription, DiskDescription, SphereDescription,
                                   CylinderDescription, InstanceDescription>;
using ShapeDescription = ShapeDescriptions::Variant;
/// Shapes that are seen where instances put them, and nowhere else. None of them is an instance.
struct GroupDescription {
  std::vector<ShapeDescription> shapes;
};

// --- Lights that are not surfaces ---------------------------------------------------------------------------------

struct PointLightDescription {
  Vec3d position, intensity;  // intensity: power per solid angle
};
/// Light within a cone of half angle `cutoff`, full within `beam`, in degrees (see lights/spot_light.h).
struct SpotLightDescription {
  Vec3d position, direction;  // direction: of any length
  Vec3d intensity;            // power per solid angle along the direction
  double cutoff_degrees = 20, beam_degrees = 15;
  std::optional<std::uint32_t> texture = {};  // of the textures: multiplies the intensity, see lights/spot_light.h
  Vec3d u_axis{1, 0, 0}, v_axis{0, 1, 0};     // where it grows: of any length, across the direction
};
struct DirectionalLightDescription {
  Vec3d direction;   // in which light travels, of any length
  Vec3d irradiance;  // power per area across the direction
};
struct ConstantEnvironmentDescription {
  Vec3d radiance;
};
using EnvironmentDescription = std::variant<ConstantEnvironmentDescription, ImageEnvironmentDescription>;

// --- Scene --------------------------------------------------------------------------------------------------------

struct SceneDescription {
  std::vector<BsdfDescription> bsdfs = {};
  std::vector<TextureDescription> textures = {};
  std::vector<TextureBinding> bindings = {};
  std::vector<NormalMapDescription> normal_maps = {};
  std::vector<ShapeDescription> shapes = {};
  std::vector<GroupDescription> groups = {};
  std::vector<PointLightDescription> point_lights = {};
  std::vector<SpotLightDescription> spot_lights = {};
  std::vector<DirectionalLightDescription> directional_lights = {};
  std::optional<EnvironmentDescription> environment = {};
  std::vector<MediumDescription> media = {};
  std::optional<std::uint32_t> camera_medium = {};  // where the sensor stands; vacuum if not given
  bool count_null_interfaces = true;                // whether a null interface counts as a vertex for max_depth
  bool hides_emitters = false;                      // from the camera: see transport/hidden_emitters.h
  SensorDescription sensor = PerspectiveDescription{};
  std::vector<MotionKey> sensor_keys = {};  // stand for the sensor's to_world, and make it move
  FilmDescription film = {};
  bool keeps_uvs = false;  // of surfaces without textures too
};

/// Whether all keys are equal.
[[nodiscard]] inline bool stays(const std::vector<MotionKey>& keys) noexcept {
  return std::all_of(keys.begin(), keys.end(),
                     [&](const MotionKey& key) { return key.to_world.m == keys.front().to_world.m; });
}

}  // namespace equaltime
