// MeshEmission: the mean emission of each triangle of a mesh with an emission texture, and its distribution over the
// triangle. Integrals are exact, in float64: a triangle is cut along the lines where the texture's interpolation
// changes. If that makes too many pieces, each is sampled at one point, and a small constant covers what such points
// may miss.
#pragma once

#include <array>
#include <memory>

#include "equaltime/sampling/image_distribution.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

struct TriangleEmission {
  double mean;  // over the triangle, of the mean of the channels
  /// Over the square of TexturedTriangle; null if the emission is nearly constant.
  std::shared_ptr<const ImageDistribution> distribution;
};

class MeshEmission {
 public:
  /// Emission of a texture times a colour on a mesh of that many triangles. `meshes` such meshes of the scene share the
  /// limit of work per scene equally, as the triangles share the limit of their mesh.
  MeshEmission(const Texture& texture, const Spectrum& color, std::size_t triangles, std::size_t meshes);

  /// Emission of the triangle with these corners, in the order of its light. `finest`: most cells along a side of its
  /// distribution.
  [[nodiscard]] TriangleEmission of(const std::array<TextureCoords, 3>& corners, double finest) const;

 private:
  struct Footprint;
  [[nodiscard]] Footprint footprint(const std::array<TextureCoords, 3>& corners) const noexcept;
  /// Mean of the absolute channels at a point.
  [[nodiscard]] double bright(const TextureCoords& at) const noexcept;
  [[nodiscard]] double integral(const Footprint& footprint, std::size_t column, std::size_t row,
                                std::size_t cells) const noexcept;

  const Texture& texture_;
  Spectrum color_;
  std::optional<TextureLattice> lattice_;
  double most_pieces_, coarse_pieces_, most_cells_, typical_;
};

}  // namespace equaltime
