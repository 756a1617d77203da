#include "equaltime/bsdfs/microfacet.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

constexpr float kInvSqrtPi = 0.56418958354775628695F;

/// Inverse error function to about 1e-6 relative (Giles 2010, single precision).
float erf_inverse(float x) noexcept {
  float w = -elementary::log((1 - x) * (1 + x));
  float p;
  if (w < 5) {
    w -= 2.5F;
    p = 2.81022636e-08F;
    for (const float c : {3.43273939e-07F, -3.5233877e-06F, -4.39150654e-06F, 0.00021858087F, -0.00125372503F,
                          -0.00417768164F, 0.246640727F, 1.50140941F})
      p = c + p * w;
  } else {
    w = std::sqrt(w) - 3;
    p = -0.000200214257F;
    for (const float c : {0.000100950558F, 0.00134934322F, -0.00367342844F, 0.00573950773F, -0.0076224613F,
                          0.00943887047F, 1.00167406F, 2.83297682F})
      p = c + p * w;
  }
  return p * x;
}

/// Quantile of a standard Gaussian slope exp(-x²)/√π; u in [0, 1).
float slope_quantile(float u) noexcept {
  return erf_inverse(std::clamp(2 * u - 1, -kOneMinusEpsilon, kOneMinusEpsilon));
}

/// The slope along the direction of view at quantile u of the visible slopes, whose density is proportional to
/// (cosθ - x·sinθ)·exp(-x²) up to x = cotθ. Newton's method on the cumulative function, kept within a bracket.
float visible_slope(float cos_theta, float u) noexcept {
  const float sin_theta = safe_sqrt((1 - cos_theta) * (1 + cos_theta));
  const auto cumulative = [&](float x) noexcept {
    return cos_theta * 0.5F * (1 + elementary::erf(x)) + sin_theta * 0.5F * kInvSqrtPi * elementary::exp(-x * x);
  };
  float lo = -6.0F;  // beyond it, less than 2^-52 of the slopes
  float hi = sin_theta * 6.0F > cos_theta ? cos_theta / sin_theta : 6.0F;
  const float target = u * cumulative(hi);
  float x = std::clamp(slope_quantile(u), lo, hi);
  for (int i = 0; i < 16; ++i) {
    const float error = cumulative(x) - target;
    (error > 0 ? hi : lo) = x;
    const float derivative = (cos_theta - x * sin_theta) * kInvSqrtPi * elementary::exp(-x * x);
    float next = derivative >= std::numeric_limits<float>::min() ? x - error / derivative : lo;
    if (!(next > lo && next < hi)) next = 0.5F * (lo + hi);
    const float step = std::abs(next - x);
    x = next;
    if (step <= 1e-6F * (1 + std::abs(x))) break;
  }
  return x;
}

}  // namespace

Vec3f sample_beckmann(float alpha_u, float alpha_v, const Vec3f& wo, Point2f u) noexcept {
  const Vec3f w = normalize(Vec3f{alpha_u * wo.x, alpha_v * wo.y, wo.z});
  const float x = visible_slope(std::min(w.z, 1.0F), u.x);
  const float y = slope_quantile(u.y);
  const float r = std::sqrt(w.x * w.x + w.y * w.y);
  const float cos_phi = r > 0 ? w.x / r : 1.0F;
  const float sin_phi = r > 0 ? w.y / r : 0.0F;
  return normalize(Vec3f{-alpha_u * (x * cos_phi - y * sin_phi), -alpha_v * (x * sin_phi + y * cos_phi), 1.0F});
}

}  // namespace equaltime
