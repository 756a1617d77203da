// What a surface is made of, as the path loop reads it: one record a shape, and the error bounds of points on it.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry.h"
#include "math/spectrum.h"
#include "scene/interaction.h"

namespace equaltime {

/// Bound of what float64 leaves between a computed point and its surface, anywhere in normalised space (2^11 across,
/// some ten roundings). In a plane through the origin it is all there is, and enough to put a point behind it.
inline constexpr float kExactOffset = 0x1p-37F;

/// Bound of the rounding of a float32 point on an exact (float64) surface with unit normal n.
[[nodiscard]] inline float point_offset(const Vec3f& p, const Vec3f& n) noexcept {
  return 4 * kUnitRoundoff * dot(abs(n), abs(p)) + kExactOffset;
}

/// The plane of a triangle, and how far from it a ray must start so as not to meet the triangle. One record holds all
/// that a flat triangle's interaction needs: neither its vertices nor their indices are read.
struct TrianglePlane {
  Vec3d n;   // unit geometric normal
  double d;  // n·p of the plane's points
  float offset;

  /// The point of the triangle that Embree says is hit: on the ray, and on the plane to float64.
  [[nodiscard]] EQUALTIME_INLINE Vec3d meet(const RayD& ray) const noexcept {
    const double slope = dot(ray.direction, n);
    // A ray within the plane meets it in no single point: its own origin, which is in the plane, stands for it.
    const double t = slope != 0 ? (d - dot(ray.origin, n)) / slope : 0.0;
    return ray.origin + ray.direction * t;
  }
};

/// Embree's robust test translates the vertices to the ray's origin and forms the plane from their rounded differences;
/// the terms of the offset bound, in order, the rounding of a point on the triangle, of the translated vertices and of
/// the plane's normal. Tested on random triangles (tests/hard).
[[nodiscard]] inline TrianglePlane triangle_plane(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2) noexcept {
  const Vec3d scaled_normal = cross(Vec3d(v1) - Vec3d(v0), Vec3d(v2) - Vec3d(v0));
  const double norm = length(scaled_normal);
  const Vec3d n = scaled_normal / norm;
  const Vec3d reach(max(abs(v0), max(abs(v1), abs(v2))));
  const Vec3d e(max(abs(v1 - v0), max(abs(v2 - v0), abs(v2 - v1))));
  const double bound = dot(abs(n), reach + e) + 3 * e.x * e.y * e.z / norm;
  return {n, dot(n, Vec3d(v0)), static_cast<float>(4 * static_cast<double>(kUnitRoundoff) * bound) + kExactOffset};
}

/// Of a shape without a priority; see scene/nesting.h.
inline constexpr std::uint8_t kNoRank = 255;

enum class SurfaceKind : std::uint8_t { mesh, sphere, disk, cylinder };

struct Surface {
  std::uint32_t bsdf[2] = {kNone, kNone};   // front, back
  std::uint32_t first_light = kNone;        // in the scene's lights
  bool light_per_primitive = false;         // each triangle is a light of its own
  Spectrum radiance;                        // leaving the front side, normalised
  std::uint32_t emission = kNone;           // the texture that multiplies it
  std::uint32_t media[2] = {kNone, kNone};  // before the front, behind it; kNone: vacuum
  bool bounds_media = false;                // a path that leaves it is in one of these; otherwise where it was
  std::uint8_t rank = kNoRank;              // of the body that it is the surface of
  bool flipped = false;                     // front is against the geometric normal (spheres, disks)
  std::vector<TrianglePlane> planes;        // of each triangle (meshes)
  std::vector<Vec3f> normals;               // one a vertex, or none (meshes)
  std::vector<Vec3f> tangents;              // one a triangle if a BSDF is anisotropic, or none (meshes)
  SurfaceKind kind = SurfaceKind::mesh;
  bool textured = false;       // a texture looks at where on the surface a point is
  bool tangential = false;     // a BSDF looks at the azimuth of directions
  std::uint32_t mesh = kNone;  // its number among the scene's meshes, if it is one
  std::vector<Point2f> uvs;    // one a vertex, or none; of textured meshes only
  // Of spheres, cylinders and disks: the axis round which azimuth is counted, as long as a cylinder; across it, where
  // azimuth is 0 and a quarter turn, as long as a disk's radii; and the radius of what is round. The size of a mesh is
  // its author's unit, in its own space.
  Vec3f pole, azimuth[2];
  float size = 0;
  std::vector<std::vector<Vec3f>> later_normals;  // of a mesh that deforms, as its later vertices
  std::uint32_t shown_as = kNone;                 // another shape, which is how its author knows it: one that moves
};

}  // namespace equaltime
