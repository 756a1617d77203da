// SceneDescription: a scene as plain data, in world space, in the units of its author, in float64.
// It is what a reader fills in and what `build_scene` compiles; it knows nothing of how scenes are rendered.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "math/motion.h"
#include "math/spectrum.h"
#include "math/transform.h"
#include "math/vector.h"
#include "scene/texture_description.h"

namespace equaltime {

// --- BSDFs: one-sided leaves; shapes say which one stands on which side -------------------------------------------

struct DiffuseDescription {
  Vec3d reflectance;
};
struct ConductorDescription {
  Vec3d eta, k, specular_reflectance;
};
enum class MicrofacetModel : std::uint8_t { ggx, beckmann };
struct RoughConductorDescription {
  MicrofacetModel model = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1;
  Vec3d eta, k, specular_reflectance;
};
struct DielectricDescription {
  double ior = 1.5;  // interior over exterior
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};
struct ThinDielectricDescription {
  double ior = 1.5;  // of the sheet over that of what is round it
  Vec3d specular_reflectance{1, 1, 1}, specular_transmittance{1, 1, 1};
};
struct RoughDielectricDescription {
  MicrofacetModel model = MicrofacetModel::ggx;
  double alpha_u = 0.1, alpha_v = 0.1;
  DielectricDescription dielectric;
};
struct PlasticDescription {
  double ior = 1.5;  // interior over exterior
  Vec3d diffuse_reflectance{0.5, 0.5, 0.5}, specular_reflectance{1, 1, 1};
  bool nonlinear = false;  // light that is reflected within takes the colour of the body each time
};
struct RoughPlasticDescription {
  MicrofacetModel model = MicrofacetModel::ggx;
  double alpha = 0.1;
  PlasticDescription plastic;
};
/// Mitsuba's words; ior is interior over exterior.
struct PrincipledDescription {
  Vec3d base_color{0.5, 0.5, 0.5};
  double roughness = 0.5, anisotropic = 0, metallic = 0, spec_trans = 0, ior = 1.5, spec_tint = 0, sheen = 0,
         sheen_tint = 0, flatness = 0, clearcoat = 0, clearcoat_gloss = 0;
};
/// Nothing: light passes straight on.
struct NullDescription {};
/// At each point one of two at random: `second` with the probability `weight`. A mask is nothing and what it hides.
struct MixtureDescription {
  std::uint32_t first, second;        // indices into SceneDescription::bsdfs, before this one
  double weight = 0.5;                // in [0, 1]
  std::optional<double> cutoff = {};  // makes the weight 1 where it is at least this, else 0
};
using BsdfDescription =
    std::variant<DiffuseDescription, ConductorDescription, RoughConductorDescription, DielectricDescription,
                 ThinDielectricDescription, RoughDielectricDescription, PlasticDescription, RoughPlasticDescription,
                 PrincipledDescription, NullDescription, MixtureDescription>;

// --- Media --------------------------------------------------------------------------------------------------------

/// A part of a phase function: Henyey and Greenstein's law, or Rayleigh's.
struct PhaseLobeDescription {
  double weight = 1;  // over the sum of all
  double g = 0;
  bool rayleigh = false;  // instead of g's law
};
/// What is between surfaces, the same everywhere; scatters by Henyey and Greenstein's law if nothing else is said.
struct MediumDescription {
  Vec3d sigma_t{1, 1, 1};                        // extinction per unit of length; where there is none, vacuum
  Vec3d albedo{0.75, 0.75, 0.75};                // the part of it that is scattering
  double g = 0;                                  // mean cosine of the angle by which light is turned
  std::vector<PhaseLobeDescription> lobes = {};  // in place of g's law, if there are any
};

// --- Shapes -------------------------------------------------------------------------------------------------------

/// What all shapes share. A side without a BSDF absorbs what reaches it; radiance leaves from the front side only.
struct SurfaceDescription {
  std::optional<std::uint32_t> front, back;  // indices into SceneDescription::bsdfs
  std::optional<Vec3d> radiance;
  std::optional<std::uint32_t> exterior = {}, interior = {};  // into its media: what is before the front, and behind
  std::optional<int> priority = {};  // of what is inside: where bodies that have one overlap, the highest is there
  std::optional<std::uint32_t> emission = {};  // of the textures, the one that multiplies the radiance, point by point
};
struct MeshDescription {
  std::vector<Vec3d> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from the front
  std::vector<Vec3d> normals;                           // one a vertex, or none
  std::vector<std::array<double, 2>> uvs;               // one a vertex, or none
  std::vector<AttributeValues> attributes;
  SurfaceDescription surface;
  /// Where the vertices are later, at evenly spaced times up to 1, if they move, and their normals, if there are any.
  std::vector<std::vector<Vec3d>> later_vertices = {}, later_normals = {};
};
struct RectangleDescription {  // the image of [-1, 1]² under to_world, front towards +z
  Transform to_world;
  bool flip_normals = false;
  SurfaceDescription surface;
};
struct DiskDescription {  // the image of the unit disk under to_world, front towards +z
  Transform to_world;
  bool flip_normals = false;
  SurfaceDescription surface;
};
struct SphereDescription {
  Vec3d center;
  double radius = 1;
  bool flip_normals = false;
  SurfaceDescription surface;
  Vec3d pole{0, 0, 1};      // the axis round which azimuth is counted
  Vec3d meridian{1, 0, 0};  // where azimuth is 0
  bool mirrored = false;    // azimuth runs the other way round
};
struct CylinderDescription {  // a tube without caps, front outwards
  Vec3d base, end;            // of its axis
  double radius = 1;
  bool flip_normals = false;
  SurfaceDescription surface;
  Vec3d meridian{1, 0, 0};  // where azimuth is 0
  bool mirrored = false;    // azimuth runs the other way round
};
/// A group of shapes, once more: to_world takes its space to the scene's. Keys, if there are any, stand for it and make
/// it move; what is the only instance of its group, and has keys, may emit.
struct InstanceDescription {
  std::uint32_t group = 0;
  Transform to_world;
  std::vector<MotionKey> keys = {};
};
using ShapeDescription = std::variant<MeshDescription, RectangleDescription, DiskDescription, SphereDescription,
                                      CylinderDescription, InstanceDescription>;
/// Shapes that are seen where instances put them, and nowhere else. None of them is an instance.
struct GroupDescription {
  std::vector<ShapeDescription> shapes;
};

// --- Emitters that are not surfaces -------------------------------------------------------------------------------

struct PointLightDescription {
  Vec3d position, intensity;  // intensity: power per solid angle
};
/// Light within a cone of half angle `cutoff`, full within `beam`, in degrees (see scene/spot_light.h).
struct SpotLightDescription {
  Vec3d position, direction;  // direction: of any length
  Vec3d intensity;            // power per solid angle along the direction
  double cutoff_degrees = 20, beam_degrees = 15;
  std::optional<std::uint32_t> texture = {};  // of the textures: multiplies the intensity, see scene/spot_light.h
  Vec3d u_axis{1, 0, 0}, v_axis{0, 1, 0};     // where it grows: of any length, across the direction
};
struct DirectionalLightDescription {
  Vec3d direction;   // in which light travels, of any length
  Vec3d irradiance;  // power per area across the direction
};
struct ConstantEnvironmentDescription {
  Vec3d radiance;
};
struct ImageEnvironmentDescription {
  std::uint32_t width = 0, height = 0;
  std::vector<Spectrum> pixels;  // rows from the +y pole, as in scene/environment.h
  double scale = 1;
  Transform to_world;
};
using EnvironmentDescription = std::variant<ConstantEnvironmentDescription, ImageEnvironmentDescription>;

// --- Sensor -------------------------------------------------------------------------------------------------------

/// Camera space looks along +z, +x to the left of the image, +y up.
struct PerspectiveDescription {
  Transform to_world;  // keeps lengths
  double x_fov_degrees = 50;
  std::optional<double> near, far;  // planes across the axis; geometry outside is not seen
  double principal_point_x = 0, principal_point_y = 0;
};
/// A perspective whose lens is a disk, or as many blades as are given leave a regular polygon of it: only what is at
/// focus_distance along the axis is sharp. A radius of 0 makes it a pinhole.
struct ThinLensDescription {
  PerspectiveDescription view;
  double aperture_radius = 0, focus_distance = 1;  // radius: of the polygon's corners, too
  std::uint32_t blades = 0;                        // none, or 3 at the least
  double rotation_degrees = 0;                     // of a corner, from the camera's +x to its +y
};
/// Parallel rays along the camera's +z from the plane of its origin: the film's width is [-1, 1] of its x axis.
struct OrthographicDescription {
  Transform to_world;               // may scale: that is how its size is said
  std::optional<double> near, far;  // in camera space
};
/// All directions from one point: the film's width is once round the camera's y axis, its height from +y to -y; its
/// middle looks along +z.
struct SphericalDescription {
  Transform to_world;               // keeps lengths
  std::optional<double> near, far;  // distances from the camera
};
using SensorDescription =
    std::variant<PerspectiveDescription, ThinLensDescription, OrthographicDescription, SphericalDescription>;
enum class FilterKind : std::uint8_t { box, tent, gaussian, mitchell, lanczos };
struct FilmDescription {
  std::uint32_t width = 256, height = 256;
  std::uint32_t crop_x = 0, crop_y = 0, crop_width = 256, crop_height = 256;
  FilterKind filter = FilterKind::box;
  // box, tent: radius; gaussian: standard deviation, cut at four of them; mitchell: B and C; lanczos: radius
  double filter_parameter = 0.5, second_filter_parameter = 0;
};

struct SceneDescription {
  std::vector<BsdfDescription> bsdfs;
  std::vector<TextureDescription> textures;
  std::vector<TextureBinding> bindings;
  std::vector<BendDescription> bends;
  std::vector<ShapeDescription> shapes;
  std::vector<GroupDescription> groups;
  std::vector<PointLightDescription> point_lights;
  std::vector<SpotLightDescription> spot_lights;
  std::vector<DirectionalLightDescription> directional_lights;
  std::optional<EnvironmentDescription> environment;
  std::vector<MediumDescription> media;
  std::optional<std::uint32_t> camera_medium;  // where the sensor stands; vacuum if not given
  bool crossings_are_vertices = true;          // of paths: going through a surface of nothing is as long as a bounce
  bool hides_emitters = false;                 // from the camera: see transport/hidden.h
  SensorDescription sensor = PerspectiveDescription{};
  std::vector<MotionKey> sensor_keys;  // stand for the sensor's to_world, and make it move
  FilmDescription film;
  bool keeps_uvs = false;  // of surfaces without textures too
};

/// Where the sensor stands and looks.
[[nodiscard]] inline const Transform& placement(const SensorDescription& sensor) noexcept {
  if (const auto* lens = std::get_if<ThinLensDescription>(&sensor)) return lens->view.to_world;
  if (const auto* parallel = std::get_if<OrthographicDescription>(&sensor)) return parallel->to_world;
  if (const auto* spherical = std::get_if<SphericalDescription>(&sensor)) return spherical->to_world;
  return std::get_if<PerspectiveDescription>(&sensor)->to_world;
}

inline void place(SensorDescription& sensor, const Transform& to_world) noexcept {
  if (auto* lens = std::get_if<ThinLensDescription>(&sensor))
    lens->view.to_world = to_world;
  else
    std::visit(
        [&](auto& any) {
          if constexpr (requires { any.to_world; }) any.to_world = to_world;
        },
        sensor);
}

/// Whether all keys say the same.
[[nodiscard]] inline bool stays(const std::vector<MotionKey>& keys) noexcept {
  return std::all_of(keys.begin(), keys.end(),
                     [&](const MotionKey& key) { return key.to_world.m == keys.front().to_world.m; });
}

}  // namespace equaltime
