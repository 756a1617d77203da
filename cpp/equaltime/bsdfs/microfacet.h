// Microfacet distributions over half-vectors m, local frame: GGX and Beckmann, anisotropic, with Smith shadowing.
// D is per solid angle of m. It is formed from the half-vector's x and y, so that small roughness loses no accuracy.
// Visible normals: GGX by spherical caps (Dupuy & Benyoub 2023), Beckmann by inversion in slope space (Heitz 2014).
#pragma once

#include "equaltime/math/elementary.h"
#include "equaltime/math/numeric.h"
#include "equaltime/math/vector.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

enum class MicrofacetModel : std::uint8_t { ggx, beckmann };

/// A normal that is visible from wo, of Beckmann's distribution: by Newton's method, for one path at a time.
[[nodiscard]] Vec3f sample_beckmann(float alpha_u, float alpha_v, const Vec3f& wo, Point2f u) noexcept;

/// All lanes have the same model, each a roughness of its own.
template <class Real>
class Microfacet {
 public:
  /// What roughness a texture may give at least, as in Mitsuba: 0 would be a mirror.
  static constexpr float kSmallestAlpha = 1e-4F;

  Microfacet(MicrofacetModel model, Real alpha_u, Real alpha_v) noexcept
      : alpha_u_(alpha_u), alpha_v_(alpha_v), model_(model) {}

  /// Sets a roughness that textures give.
  void set_alpha(Real alpha_u, Real alpha_v) noexcept {
    alpha_u_ = max(alpha_u, Real(kSmallestAlpha));
    alpha_v_ = max(alpha_v, Real(kSmallestAlpha));
  }

  [[nodiscard]] Real alpha_u() const noexcept { return alpha_u_; }
  [[nodiscard]] Real alpha_v() const noexcept { return alpha_v_; }
  [[nodiscard]] MicrofacetModel model() const noexcept { return model_; }
  [[nodiscard]] Mask<Real> anisotropic() const noexcept { return alpha_u_ != alpha_v_; }

  [[nodiscard]] Real D(const Vec3<Real>& m) const noexcept {
    const Real slope = square(m.x / alpha_u_) + square(m.y / alpha_v_);
    const Real z2 = m.z * m.z;
    const Real norm = kPi * alpha_u_ * alpha_v_;
    if (model_ == MicrofacetModel::ggx) return 1 / (norm * square(slope + z2));
    const Real left = elementary::exp(-slope / z2);
    return where(left > 0, [&] { return left / (norm * square(z2)); });
  }

  /// Shadowing-masking of one direction, as the model is defined: for Beckmann that is the rational fit of Walter et
  /// al. 2007 (eq. 27, within 0.35 % of Smith's integral), as Mitsuba has it.
  [[nodiscard]] Real G1(const Vec3<Real>& v) const noexcept {
    if (model_ == MicrofacetModel::ggx) return ggx_g1(v);
    const Real a = inverse_slope(v);
    return where(
        a >= 1.6F, [] { return Real(1); },
        [&] { return (3.535F * a + 2.181F * a * a) / (1 + 2.276F * a + 2.577F * a * a); });
  }

  /// Density of the visible normals seen from wo at m, over the solid angle of m; exactly what `sample` draws.
  [[nodiscard]] Real visible_pdf(const Vec3<Real>& wo, const Vec3<Real>& m) const noexcept {
    return D(m) * smith_g1(wo) * dot(wo, m) / wo.z;
  }
  /// visible_pdf / (4 wo·m): the density of the reflected direction.
  [[nodiscard]] Real reflected_pdf(const Vec3<Real>& wo, Real d) const noexcept {
    return d * smith_g1(wo) / (4 * wo.z);
  }

  [[nodiscard]] Vec3<Real> sample(const Vec3<Real>& wo, Point2<Real> u) const noexcept {
    if (model_ == MicrofacetModel::ggx) return sample_ggx(wo, u);
    return for_each_lane<Real>(sample_beckmann, alpha_u_, alpha_v_, wo, u);
  }

 private:
  /// 1 / (α·tanθ) with the roughness of v's azimuth; infinite at normal incidence.
  [[nodiscard]] Real inverse_slope(const Vec3<Real>& v) const noexcept {
    const Real slope = sqrt(square(alpha_u_ * v.x) + square(alpha_v_ * v.y));
    return where(
        slope >= std::numeric_limits<float>::min(), [&] { return v.z / slope; }, [] { return Real(kInfinity); });
  }
  [[nodiscard]] Real ggx_g1(const Vec3<Real>& v) const noexcept {
    const Real slope2 = (square(alpha_u_ * v.x) + square(alpha_v_ * v.y)) / square(v.z);
    return 2 / (1 + sqrt(1 + slope2));
  }
  /// Smith's masking without approximation: it normalises the visible normals.
  [[nodiscard]] Real smith_g1(const Vec3<Real>& v) const noexcept {
    if (model_ == MicrofacetModel::ggx) return ggx_g1(v);
    const Real a = inverse_slope(v);
    return where(
        a > 4, [] { return Real(1); },
        [&] { return 2 / (1 + elementary::erf(a) + elementary::exp(-a * a) / (a * 1.7724539F)); });
  }

  [[nodiscard]] Vec3<Real> sample_ggx(const Vec3<Real>& wo, Point2<Real> u) const noexcept {
    const Vec3<Real> w = normalize(Vec3<Real>{alpha_u_ * wo.x, alpha_v_ * wo.y, wo.z});
    const Real z = (1 - u.y) * (1 + w.z) - w.z;
    const Real r = safe_sqrt((1 - z) * (1 + z));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.x);
    return normalize(Vec3<Real>{alpha_u_ * (r * cos_phi + w.x), alpha_v_ * (r * sin_phi + w.y), max(Real(0), z + w.z)});
  }

  Real alpha_u_, alpha_v_;
  MicrofacetModel model_;
};

}  // namespace equaltime
