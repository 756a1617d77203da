// Emission of surfaces, as scenes are built: the area lights, each with what it sends on the average where a texture
// says how much that is.
#pragma once

#include <vector>

#include "equaltime/scene/emitter.h"
#include "equaltime/scene/lights.h"
#include "equaltime/scene/surface.h"
#include "equaltime/textures/texture.h"
#include "equaltime/textures/texture_distribution.h"
#include "equaltime/textures/triangle_distribution.h"

namespace equaltime {

/// The mean of a texture over the unit square, roughly, and no less than a little: what shines at all must have a
/// chance to be picked.
[[nodiscard]] Spectrum mean_over_square(const Texture& texture) noexcept;

struct AreaLightBuilder {
  const std::vector<Texture>& textures;
  std::size_t pictured_meshes = 1;  // meshes of the scene whose triangles may have pictures
  std::vector<AreaLight> lights = {};
  std::vector<Emitter> emitters = {};  // one a light

  /// Lets the surface of a shape shine by a texture. Throws std::invalid_argument if there is none of that number.
  void set_emission(Surface& surface, std::size_t shape, std::uint32_t texture) const;
  /// The mean over a rectangle, a sphere, a disk or a cylinder, roughly.
  [[nodiscard]] Spectrum mean_radiance(const Surface& surface) const noexcept;
  void add(Surface& surface, std::size_t shape, std::size_t primitive, const AreaLight& light);
  /// A rectangle, by its texture if it has one.
  void add_rectangle(Surface& surface, std::size_t shape, const Vec3f& corner, const Vec3d& edge_x, const Vec3d& edge_y,
                     bool flipped);
  /// One light a triangle.
  void add_triangles(std::size_t shape, const TriangleMesh& mesh, Surface& surface, bool flipped);
  /// How bright the texture of a mesh makes each triangle: none so little that it would never be picked.
  [[nodiscard]] std::vector<TriangleEmission> shines_of(std::size_t shape, const TriangleMesh& mesh,
                                                        const Surface& surface, bool flipped) const;
};

}  // namespace equaltime
