// Makes the area lights of a scene. A light whose emission has a texture gets its mean radiance.
#pragma once

#include <vector>

#include "equaltime/scene/emitter.h"
#include "equaltime/scene/lights.h"
#include "equaltime/scene/surface.h"
#include "equaltime/textures/texture.h"
#include "equaltime/textures/texture_distribution.h"
#include "equaltime/textures/triangle_distribution.h"

namespace equaltime {

/// Estimate of a texture's mean over the unit square. It is positive for every texture, so that light sampling can pick
/// every emitter.
[[nodiscard]] Spectrum mean_over_square(const Texture& texture) noexcept;

struct AreaLightBuilder {
  const std::vector<Texture>& textures;
  std::size_t textured_emitters = 1;  // surfaces of the scene that emit by a texture
  std::vector<AreaLight> lights = {};
  std::vector<Emitter> emitters = {};  // one per light

  /// Sets the texture of a surface's emission. Throws std::invalid_argument if the texture does not exist.
  void set_emission(Surface& surface, std::size_t shape, std::uint32_t texture) const;
  /// Estimate of the mean radiance of a rectangle, sphere, disk or cylinder.
  [[nodiscard]] Spectrum mean_radiance(const SurfaceEmission& emission) const noexcept;
  void add(Surface& surface, std::size_t shape, std::size_t primitive, const AreaLight& light);
  /// Adds a rectangle, with the distribution of its texture if it has one.
  void add_rectangle(Surface& surface, std::size_t shape, const Vec3f& corner, const Vec3d& edge_x, const Vec3d& edge_y,
                     bool flipped);
  /// Adds one light per triangle.
  void add_triangles(std::size_t shape, const TriangleMesh& mesh, Surface& surface, bool flipped);
  /// Mean and distribution of each triangle's emission. Every mean is large enough for light sampling to pick it.
  [[nodiscard]] std::vector<TriangleEmission> triangle_emissions(std::size_t shape, const TriangleMesh& mesh,
                                                                 const Surface& surface, bool flipped) const;
};

}  // namespace equaltime
