// Textures as plain data: what a reader fills in. Texture coordinates are Mitsuba's: (0, 0) is the corner of a bitmap's
// first texel, u grows along its rows and v from row to row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "math/vector.h"
#include "scene/bsdf_types.h"

namespace equaltime {

enum class TexelFormat : std::uint8_t { u8, half, float32 };
enum class TextureFilter : std::uint8_t { nearest, bilinear };
enum class TextureWrap : std::uint8_t { repeat, mirror, clamp };

/// (u, v) → (a·u + b·v + c, d·u + e·v + f), with {a, b, c, d, e, f}.
using UvTransform = std::array<double, 6>;
inline constexpr UvTransform kSameUv{1, 0, 0, 0, 1, 0};

struct BitmapDescription {
  std::uint32_t width = 1, height = 1, channels = 3;  // channels: 1 (grey) or 3
  TexelFormat format = TexelFormat::float32;
  std::vector<std::byte> texels;  // row by row, in the machine's own byte order
  bool srgb = false;              // u8 texels are encoded as sRGB; all others are linear
  TextureFilter filter = TextureFilter::bilinear;
  TextureWrap wrap = TextureWrap::repeat;
  UvTransform to_uv = kSameUv;
};
/// One colour where u and v lie in the same half of their unit interval, another elsewhere.
struct CheckerboardDescription {
  Vec3d color0, color1;
  UvTransform to_uv = kSameUv;
};
/// What each mesh says of itself, vertex by vertex or face by face: see MeshDescription::attributes.
struct MeshAttributeDescription {};
using TextureDescription = std::variant<BitmapDescription, CheckerboardDescription, MeshAttributeDescription>;

/// The values of a mesh for a texture that is a MeshAttributeDescription.
struct AttributeValues {
  std::uint32_t texture;
  std::uint32_t width = 3;    // numbers a vertex or a face: 1 or 3
  bool per_face = false;      // else they are interpolated between the vertices
  std::vector<float> values;  // width of each vertex or face in order
};

/// A parameter of a BSDF that a texture gives, in place of the constant in the BSDF's own description.
struct TextureBinding {
  std::uint32_t bsdf;
  BsdfParameter parameter;
  std::uint32_t texture;
  std::optional<std::uint32_t> times = {};  // another texture that multiplies it
};

/// What a texture does to the shading normal of a BSDF that is no mixture: a bump map is a height, in the author's
/// units of length; a normal map is (n + 1) / 2 in the frame whose first axis follows u.
struct BendDescription {
  std::uint32_t bsdf, texture;
  bool bump = false;
  double scale = 1;          // of a height
  bool flip_invalid = true;  // a normal bent away from the viewer is turned over, about the shading normal
  bool shadowing = true;     // by Conty Estevez et al. (2019), "A Microfacet-Based Shadowing Function"
  bool turned = false;       // for a back side: the normal is the front's turned round, not its mirror image
};

}  // namespace equaltime
