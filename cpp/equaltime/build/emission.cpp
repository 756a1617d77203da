#include "equaltime/build/emission.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "equaltime/build/build_meshes.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

namespace {

constexpr int kSquareSteps = 64;
/// Fraction of the largest value found, added to the mean for texels that no step sampled.
constexpr float kLeast = 1e-3F;
/// Least mean of a triangle relative to the mean of its mesh: rounding may look up a bright texel at a dark border, and
/// light sampling must be able to reach that point.
constexpr double kDarkest = 0x1p-20;
/// Least width of a cell of a triangle's distribution, in rounding errors of its points.
constexpr double kRoundings = 32;

/// Corners in the order that gives the light's front the side that emits.
std::array<Vec3f, 3> corners_of(const TriangleMesh& mesh, std::size_t triangle, bool flipped) noexcept {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {mesh.vertices[a], mesh.vertices[flipped ? c : b], mesh.vertices[flipped ? b : c]};
}

/// Most cells along a side of a triangle's distribution; with more, rounding would move points to other cells.
double finest(const std::array<Vec3f, 3>& corners) noexcept {
  const Vec3d e1 = Vec3d(corners[1]) - Vec3d(corners[0]), e2 = Vec3d(corners[2]) - Vec3d(corners[0]);
  const double longest = std::sqrt(std::max({length_squared(e1), length_squared(e2), length_squared(e2 - e1)}));
  const auto rounding = static_cast<double>(triangle_plane(corners[0], corners[1], corners[2]).offset);
  return length(cross(e1, e2)) / longest / (kRoundings * rounding);
}

}  // namespace

Spectrum mean_over_square(const Texture& texture) noexcept {
  Spectrum sum;
  float largest = 0;
  constexpr float kStep = 1.0F / kSquareSteps;
  for (int i = 0; i < kSquareSteps; ++i)
    for (int j = 0; j < kSquareSteps; ++j) {
      const Spectrum value =
          eval(texture, {{(static_cast<float>(i) + 0.5F) * kStep, (static_cast<float>(j) + 0.5F) * kStep}});
      sum += value;
      largest = std::max(largest, value.max_component());
    }
  return sum * (kStep * kStep) + Spectrum(kLeast * (largest > 0 ? largest : 1));
}

void AreaLightBuilder::set_emission(Surface& surface, std::size_t shape, std::uint32_t texture) const {
  if (texture >= textures.size()) fail(shape, "no texture " + std::to_string(texture) + " to shine by");
  if (const auto color = constant(textures[texture])) {
    surface.emission.radiance *= *color;
  } else {
    surface.emission.texture = texture;
    surface.textured = true;
  }
}

Spectrum AreaLightBuilder::mean_radiance(const SurfaceEmission& emission) const noexcept {
  if (emission.texture == kNone) return emission.radiance;
  return emission.radiance * mean_over_square(textures[emission.texture]);
}

void AreaLightBuilder::add(Surface& surface, std::size_t shape, std::size_t primitive, const AreaLight& light) {
  if (surface.emission.first_light == kNone) surface.emission.first_light = static_cast<std::uint32_t>(lights.size());
  lights.push_back(light);
  emitters.push_back({static_cast<std::uint32_t>(shape), static_cast<std::uint32_t>(primitive)});
}

void AreaLightBuilder::add_rectangle(Surface& surface, std::size_t shape, const Vec3f& corner, const Vec3d& edge_x,
                                     const Vec3d& edge_y, bool flipped) {
  const SurfaceEmission& emission = surface.emission;
  const auto lit_by = [&](const Spectrum& mean) { return rectangle_light(corner, edge_x, edge_y, flipped, mean); };
  if (emission.texture == kNone || std::holds_alternative<MeshAttribute>(textures[emission.texture]))
    return add(surface, shape, 0, lit_by(mean_radiance(emission)));
  const auto picture =
      std::make_shared<const ImageDistribution>(picture_of(textures[emission.texture], emission.radiance));
  add(surface, shape, 0, TexturedRectangle(lit_by(Spectrum(static_cast<float>(picture->mean()))), picture));
}

void AreaLightBuilder::add_triangles(std::size_t shape, const TriangleMesh& mesh, Surface& surface, bool flipped) {
  if (surface.emission.radiance.is_black()) return;
  surface.emission.light_per_primitive = true;
  std::vector<TriangleEmission> emissions;
  if (surface.emission.texture != kNone) emissions = triangle_emissions(shape, mesh, surface, flipped);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = corners_of(mesh, i, flipped);
    if (emissions.empty()) {
      add(surface, shape, i, triangle_light(a, b, c, surface.emission.radiance));
      continue;
    }
    const TriangleLight<float> light = triangle_light(a, b, c, Spectrum(static_cast<float>(emissions[i].mean)));
    if (emissions[i].distribution)
      add(surface, shape, i, TexturedTriangle(light, emissions[i].distribution));
    else
      add(surface, shape, i, light);
  }
}

std::vector<TriangleEmission> AreaLightBuilder::triangle_emissions(std::size_t shape, const TriangleMesh& mesh,
                                                                   const Surface& surface, bool flipped) const {
  const MeshEmission mesh_emission(textures[surface.emission.texture], surface.emission.radiance, mesh.triangles.size(),
                                   textured_emitters);
  const Point2f* uvs = surface.mesh.uvs.empty() ? nullptr : surface.mesh.uvs.data();
  std::vector<TriangleEmission> emissions;
  double total = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto coords = [&](float u, float v) {
      return on_triangle({u, v}, static_cast<std::uint32_t>(shape), static_cast<std::uint32_t>(i), mesh.triangles[i],
                         uvs);
    };
    const TextureCoords second = coords(1, 0), third = coords(0, 1);
    emissions.push_back(mesh_emission.of({coords(0, 0), flipped ? third : second, flipped ? second : third},
                                         finest(corners_of(mesh, i, flipped))));
    total += emissions.back().mean;
  }
  const double least = kDarkest * (total > 0 ? total / static_cast<double>(emissions.size()) : 1);
  for (TriangleEmission& of_one : emissions) of_one.mean = std::max(of_one.mean, least);
  return emissions;
}

}  // namespace equaltime
