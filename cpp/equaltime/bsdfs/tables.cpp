#include "equaltime/bsdfs/tables.h"

#include "equaltime/bsdfs/fresnel.h"
#include "equaltime/math/quadrature.h"

namespace equaltime {

namespace {

/// A grid over the random numbers that make visible normals: half the square, since wo lies in the xz plane and the
/// other half mirrors it.
struct Grid {
  struct Place {
    Point2f u;
    float weight;
  };
  std::vector<Place> places;

  Grid(MicrofacetModel model, int fine, int coarse) {
    for (const auto& [a, wa] : gauss_legendre(fine))
      for (const auto& [b, wb] : gauss_legendre(coarse)) {
        const auto x = static_cast<float>(a), half = static_cast<float>(0.5 * b);
        const Point2f u = model == MicrofacetModel::ggx ? Point2f{half, x} : Point2f{x, 0.5F + half};
        places.push_back({u, static_cast<float>(wa * wb)});
      }
  }
};

/// The mean over the normals seen from wo of what `weigh` says of each.
template <class Weigh>
float over_visible_normals(const Microfacet<float>& distribution, const Grid& grid, const Vec3f& wo, Weigh&& weigh) {
  double sum = 0;
  for (const auto& [u, weight] : grid.places) {
    const Vec3f m = distribution.sample(wo, u);
    sum += static_cast<double>(weight * weigh(m, std::min(1.0F, dot(wo, m))));
  }
  return static_cast<float>(sum);
}

}  // namespace

RoughTransmittance::RoughTransmittance(const Microfacet<float>& distribution, float ior) {
  // Total reflection has an edge that asks for more points than the rest. Good to about 3e-4; GGX, whose normals are
  // quick to make and whose tails are long, gets more points.
  const bool ggx = distribution.model() == MicrofacetModel::ggx;
  const Grid outside(distribution.model(), 32, ggx ? 16 : 8);
  const Grid inside(distribution.model(), ggx ? 96 : 64, ggx ? 32 : 16);
  double reflected = 0, entered = 0;
  for (int i = 0; i < kKnots; ++i) {
    const float cosine = std::max(1e-6F, static_cast<float>(i) / (kKnots - 1));
    const Vec3f wo{safe_sqrt((1 - cosine) * (1 + cosine)), 0, cosine};
    from_outside_[static_cast<std::size_t>(i)] =
        over_visible_normals(distribution, outside, wo, [&](const Vec3f& m, float c) {
          const auto [reflectance, refracted] = fresnel_dielectric(c, ior);
          const Vec3f wi = m * (c / ior - refracted) - wo * (1 / ior);
          return wi.z < 0 ? (1 - reflectance) * distribution.G1({wi.x, wi.y, -wi.z}) : 0.0F;
        });
    const float from_inside = over_visible_normals(distribution, inside, wo, [&](const Vec3f& m, float c) {
      const Vec3f wi = m * (2 * c) - wo;
      return wi.z > 0 ? fresnel_dielectric(c, 1 / ior).reflectance * distribution.G1(wi) : 0.0F;
    });
    reflected += 2.0 / kKnots * static_cast<double>(from_inside * cosine);
    entered += 2.0 / kKnots * static_cast<double>(from_outside_[static_cast<std::size_t>(i)] * cosine);
  }
  internal_reflectance_ = static_cast<float>(reflected);
  mean_ = static_cast<float>(entered);
}

const RoughTransmittance& BsdfTables::rough_transmittance(MicrofacetModel model, float alpha, float ior) {
  const Key key{model, alpha, ior};
  return rough_transmittances_.try_emplace(key, Microfacet<float>(model, alpha, alpha), ior).first->second;
}

}  // namespace equaltime
