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

/// Light that leaves the front side.
struct SurfaceEmission {
  std::uint32_t first_light = kNone;  // in the scene's lights; kNone: no light
  bool light_per_primitive = false;   // each triangle is a light of its own
  Spectrum radiance;                  // normalised
  std::uint32_t texture = kNone;      // multiplies the radiance
};

/// Media on both sides.
struct SurfaceMedia {
  std::uint32_t sides[2] = {kNone, kNone};  // before the front, behind it; kNone: vacuum
  bool sets_medium = false;                 // true: a path that leaves takes one of `sides`; false: it keeps its medium
  std::uint8_t rank = kNoRank;              // of the dielectric inside
};

/// Attributes of a mesh's triangles and vertices. Embree has the positions.
struct MeshAttributes {
  std::uint32_t number = kNone;                   // among the scene's meshes; kNone: the shape is no mesh
  std::vector<TrianglePlane<float>> planes;       // of each triangle
  std::vector<Vec3f> normals;                     // one a vertex, or none
  std::vector<Vec3f> tangents;                    // one a triangle if a BSDF is anisotropic, or none
  std::vector<Point2f> uvs;                       // one a vertex, or none; of textured meshes only
  std::vector<std::vector<Vec3f>> later_normals;  // of a deforming mesh, at the times of its later vertices
  float unit = 0;                                 // length of the author's unit in the mesh's space
};

/// How an analytic shape is parametrised.
struct ShapeParametrization {
  std::uint8_t kind = 0;  // place in AnalyticShapes
  Vec3f pole;             // axis of the azimuth; a cylinder's pole is as long as the cylinder
  Vec3f azimuth[2];       // directions of azimuth 0° and 90°; for a disk, their lengths are its radii
  float radius = 0;
};

struct Surface {
  std::uint32_t material[2] = {kNone, kNone};  // of the front, of the back; kNone: it absorbs
  SurfaceEmission emission;
  SurfaceMedia media;
  bool flipped = false;      // front is against the geometric normal (spheres, disks)
  bool textured = false;     // a texture looks at where on the surface a point is
  bool anisotropic = false;  // a BSDF looks at the azimuth of directions
  MeshAttributes mesh;
  ShapeParametrization analytic;
  std::uint32_t source_shape = kNone;  // number in the description, of a shape in a moving group
};

}  // namespace equaltime
