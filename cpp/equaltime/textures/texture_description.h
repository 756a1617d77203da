// Textures as plain data: what a reader fills in. Texture coordinates are Mitsuba's: (0, 0) is the corner of a bitmap's
// first texel, u grows along its rows and v from row to row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

#include "equaltime/math/vector.h"

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

}  // namespace equaltime
