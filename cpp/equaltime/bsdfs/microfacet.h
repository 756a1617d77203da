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

class Microfacet {
 public:
  /// What roughness a texture may give at least, as in Mitsuba: 0 would be a mirror.
  static constexpr float kSmallestAlpha = 1e-4F;

  Microfacet(MicrofacetModel model, float alpha_u, float alpha_v) noexcept
      : alpha_u_(alpha_u), alpha_v_(alpha_v), model_(model) {}

  /// Sets a roughness that textures give.
  void set_alpha(float alpha_u, float alpha_v) noexcept {
    alpha_u_ = std::max(alpha_u, kSmallestAlpha);
    alpha_v_ = std::max(alpha_v, kSmallestAlpha);
  }

  [[nodiscard]] float alpha_u() const noexcept { return alpha_u_; }
  [[nodiscard]] float alpha_v() const noexcept { return alpha_v_; }
  [[nodiscard]] MicrofacetModel model() const noexcept { return model_; }
  [[nodiscard]] bool anisotropic() const noexcept { return alpha_u_ != alpha_v_; }

  [[nodiscard]] float D(const Vec3f& m) const noexcept {
    const float slope = square(m.x / alpha_u_) + square(m.y / alpha_v_);
    const float z2 = m.z * m.z;
    const float norm = kPi * alpha_u_ * alpha_v_;
    if (model_ == MicrofacetModel::ggx) return 1 / (norm * square(slope + z2));
    const float left = elementary::exp(-slope / z2);
    return left > 0 ? left / (norm * square(z2)) : 0.0F;
  }

  /// Shadowing-masking of one direction, as the model is defined: for Beckmann that is the rational fit of Walter et
  /// al. 2007 (eq. 27, within 0.35 % of Smith's integral), as Mitsuba has it.
  [[nodiscard]] float G1(const Vec3f& v) const noexcept {
    if (model_ == MicrofacetModel::ggx) return ggx_g1(v);
    const float a = inverse_slope(v);
    if (a >= 1.6F) return 1.0F;
    return (3.535F * a + 2.181F * a * a) / (1 + 2.276F * a + 2.577F * a * a);
  }

  /// Density of the visible normals seen from wo at m, over the solid angle of m; exactly what `sample` draws.
  [[nodiscard]] float visible_pdf(const Vec3f& wo, const Vec3f& m) const noexcept {
    return D(m) * smith_g1(wo) * dot(wo, m) / wo.z;
  }
  /// visible_pdf / (4 wo·m): the density of the reflected direction.
  [[nodiscard]] float reflected_pdf(const Vec3f& wo, float d) const noexcept { return d * smith_g1(wo) / (4 * wo.z); }

  [[nodiscard]] Vec3f sample(const Vec3f& wo, Point2f u) const noexcept {
    return model_ == MicrofacetModel::ggx ? sample_ggx(wo, u) : sample_beckmann(wo, u);
  }

 private:
  /// 1 / (α·tanθ) with the roughness of v's azimuth; infinite at normal incidence.
  [[nodiscard]] float inverse_slope(const Vec3f& v) const noexcept {
    const float slope = std::sqrt(square(alpha_u_ * v.x) + square(alpha_v_ * v.y));
    return slope >= std::numeric_limits<float>::min() ? v.z / slope : kInfinity;
  }
  [[nodiscard]] float ggx_g1(const Vec3f& v) const noexcept {
    const float slope2 = (square(alpha_u_ * v.x) + square(alpha_v_ * v.y)) / square(v.z);
    return 2 / (1 + std::sqrt(1 + slope2));
  }
  /// Smith's masking without approximation: it normalises the visible normals.
  [[nodiscard]] float smith_g1(const Vec3f& v) const noexcept {
    if (model_ == MicrofacetModel::ggx) return ggx_g1(v);
    const float a = inverse_slope(v);
    if (a > 4) return 1.0F;
    return 2 / (1 + elementary::erf(a) + elementary::exp(-a * a) / (a * std::sqrt(kPi)));
  }

  [[nodiscard]] Vec3f sample_ggx(const Vec3f& wo, Point2f u) const noexcept {
    const Vec3f w = normalize(Vec3f{alpha_u_ * wo.x, alpha_v_ * wo.y, wo.z});
    const float z = (1 - u.y) * (1 + w.z) - w.z;
    const float r = safe_sqrt((1 - z) * (1 + z));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.x);
    return normalize(Vec3f{alpha_u_ * (r * cos_phi + w.x), alpha_v_ * (r * sin_phi + w.y), std::max(0.0F, z + w.z)});
  }
  [[nodiscard]] Vec3f sample_beckmann(const Vec3f& wo, Point2f u) const noexcept;

  float alpha_u_, alpha_v_;
  MicrofacetModel model_;
};

}  // namespace equaltime
