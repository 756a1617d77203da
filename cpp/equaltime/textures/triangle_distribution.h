// TrianglePictures: how bright a texture makes the triangles of a mesh, and where on each it is how bright. Integrals
// are exact, in float64: a triangle is cut along the lines where the texture's interpolation changes. Where these are
// too many, pieces are looked at in one point each, and a little is added for what that may miss.
#pragma once

#include <array>
#include <memory>

#include "equaltime/sampling/image_distribution.h"
#include "equaltime/textures/texture.h"

namespace equaltime {

struct TriangleEmission {
  double mean;  // of the mean of the colours, over the triangle
  std::shared_ptr<const ImageDistribution>
      picture;  // over the square of TexturedTriangle; null if it is about the same all over
};

class TrianglePictures {
 public:
  /// Pictures of a texture times a colour on one of the `meshes` of a scene that have pictures. They share the work
  /// that a scene may take, and the triangles of the mesh share its part.
  TrianglePictures(const Texture& texture, const Spectrum& color, std::size_t triangles, std::size_t meshes);

  /// Of a triangle whose corners are looked up there, in its light's order; `finest`: the most cells along a side of
  /// its picture that points can be told apart in.
  [[nodiscard]] TriangleEmission of(const std::array<TextureCoords, 3>& corners, double finest) const;

 private:
  struct Footprint;
  [[nodiscard]] Footprint footprint(const std::array<TextureCoords, 3>& corners) const noexcept;
  /// The brightness of a colour, of any sign.
  [[nodiscard]] double bright(const TextureCoords& at) const noexcept;
  [[nodiscard]] double integral(const Footprint& footprint, std::size_t column, std::size_t row,
                                std::size_t cells) const noexcept;

  const Texture& texture_;
  Spectrum color_;
  std::optional<TextureLattice> lattice_;
  double most_pieces_, coarse_pieces_, most_cells_, typical_;
};

}  // namespace equaltime
