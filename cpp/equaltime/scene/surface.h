// Surface: materials, emission, media and attributes of a shape, as the path loop reads them.
#pragma once

#include <cstdint>
#include <vector>

#include "equaltime/base/index.h"
#include "equaltime/math/point.h"
#include "equaltime/math/spectrum.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

/// Rank of a surface without a priority; see scene/nesting.h.
inline constexpr std::uint8_t kNoRank = 255;

struct Surface {
  std::uint32_t bsdf[2] = {kNone, kNone};    // front, back
  std::uint32_t first_light = kNone;         // in the scene's lights
  bool light_per_primitive = false;          // each triangle is a light of its own
  Spectrum radiance;                         // leaving the front side, normalised
  std::uint32_t emission = kNone;            // the texture that multiplies it
  std::uint32_t media[2] = {kNone, kNone};   // before the front, behind it; kNone: vacuum
  bool bounds_media = false;                 // leaving the surface sets the medium; otherwise it stays unchanged
  std::uint8_t rank = kNoRank;               // of the dielectric inside
  bool flipped = false;                      // front is against the geometric normal (spheres, disks)
  std::vector<TrianglePlane<float>> planes;  // of each triangle (meshes)
  std::vector<Vec3f> normals;                // one a vertex, or none (meshes)
  std::vector<Vec3f> tangents;               // one a triangle if a BSDF is anisotropic, or none (meshes)
  std::uint8_t kind = 0;                     // place in AnalyticShapes, unless it is a mesh
  bool textured = false;                     // a texture looks at where on the surface a point is
  bool tangential = false;                   // a BSDF looks at the azimuth of directions
  std::uint32_t mesh = kNone;                // its number among the scene's meshes, if it is one
  std::vector<Point2f> uvs;                  // one a vertex, or none; of textured meshes only
  Vec3f pole;                                // axis of the azimuth; a cylinder's has the cylinder's length
  Vec3f azimuth[2];  // directions of azimuth 0° and 90°; for a disk, their lengths are its radii
  float size = 0;    // radius; for a mesh, the length of the author's unit in the mesh's space
  std::vector<std::vector<Vec3f>> later_normals;  // of a deforming mesh, at the times of its later vertices
  std::uint32_t source_shape = kNone;             // shape of the description that a moving group's shape stands for
};

}  // namespace equaltime
