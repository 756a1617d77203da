#include "equaltime/bsdfs/principled.h"

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// Stands for an index of glass that is 1 in float32, whose facets would bend nothing: the same as Mitsuba's.
constexpr float kLeastContrast = 1.001F;
constexpr float kCoatReflectance = 0.04F, kCoatShadowing = 0.25F, kLeastAlpha = 1e-3F;

Spectrum mix(const Spectrum& a, const Spectrum& b, float share) noexcept { return a * (1 - share) + b * share; }
float mix(float a, float b, float share) noexcept { return a * (1 - share) + b * share; }
float schlick_weight(float c) noexcept {
  const float x = std::clamp(1 - c, 0.0F, 1.0F);
  return square(square(x)) * x;
}

/// Burley's GTR1 distribution of normals: heavier in the tail than GGX. Its normals are drawn in proportion to D·cosθ.
struct CoatDistribution {
  float alpha2;

  [[nodiscard]] float D(const Vec3f& m) const noexcept {
    // 1 + (α² - 1)cos², in sines, so that small roughness loses no digits
    const float across = m.x * m.x + m.y * m.y;
    return (alpha2 - 1) / (kPi * elementary::log(alpha2) * (across + alpha2 * m.z * m.z));
  }
  [[nodiscard]] Vec3f sample(Point2f u) const noexcept {
    const float sine2 = (elementary::pow(alpha2, 1 - u.y) - alpha2) / (1 - alpha2);
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.x);
    const float sine = safe_sqrt(sine2);
    return {sine * cos_phi, sine * sin_phi, safe_sqrt(1 - sine2)};
  }
};

float coat_masking(const Vec3f& v) noexcept {
  const float tan2 = (v.x * v.x + v.y * v.y) / square(v.z);
  return 2 / (1 + std::sqrt(1 + square(kCoatShadowing) * tan2));
}

}  // namespace

Principled::Principled(const PrincipledDescription& d) noexcept
    : transmits(d.spec_trans > 0),
      base_color(spectrum(d.base_color)),
      roughness(static_cast<float>(d.roughness)),
      anisotropic(static_cast<float>(d.anisotropic)),
      metallic(static_cast<float>(d.metallic)),
      spec_trans(static_cast<float>(d.spec_trans)),
      ior(static_cast<float>(d.ior)),
      spec_tint(static_cast<float>(d.spec_tint)),
      sheen(static_cast<float>(d.sheen)),
      sheen_tint(static_cast<float>(d.sheen_tint)),
      flatness(static_cast<float>(d.flatness)),
      clearcoat(static_cast<float>(d.clearcoat)),
      clearcoat_gloss(static_cast<float>(d.clearcoat_gloss)),
      distribution(MicrofacetModel::ggx, 1, 1) {
  if (transmits && ior == 1) ior = kLeastContrast;
  derive();
}

void Principled::derive() noexcept {
  // Texels may be out of range, of colours beyond the primaries or sharpened when an image was resized. The model has
  // roots of these numbers, and probabilities of them.
  base_color = {std::max(0.0F, base_color.r), std::max(0.0F, base_color.g), std::max(0.0F, base_color.b)};
  for (float* share : {&roughness, &anisotropic, &metallic, &spec_trans, &spec_tint, &sheen, &sheen_tint, &flatness,
                       &clearcoat, &clearcoat_gloss})
    *share = std::clamp(*share, 0.0F, 1.0F);
  transmits = transmits || spec_trans > 0;
  const float alpha = square(roughness), aspect = std::sqrt(1 - 0.9F * anisotropic);
  distribution =
      Microfacet(MicrofacetModel::ggx, std::max(kLeastAlpha, alpha / aspect), std::max(kLeastAlpha, alpha * aspect));
  const float luminance = base_color.luminance();
  tint_ = luminance > 0 ? base_color * (1 / luminance) : Spectrum(1);
  body_ = (1 - metallic) * (1 - spec_trans);
  glassiness_ = (1 - metallic) * spec_trans;
  glass_ = Spectrum(std::sqrt(base_color.r), std::sqrt(base_color.g), std::sqrt(base_color.b)) * glassiness_;
  coat_alpha_ = mix(0.1F, 0.001F, clearcoat_gloss);
}

Spectrum Principled::schlick(const Spectrum& r0, float c) const noexcept {
  // Coming from the denser side, light is reflected as the refracted direction is.
  const float weight = schlick_weight(ior > 1 ? c : safe_sqrt(1 - (1 - c * c) / square(ior)));
  return Spectrum(weight) + r0 * (1 - weight);
}

Principled::Facets Principled::facets(float c, float eta, float reflectance, bool front) const noexcept {
  Facets f;
  f.transmittance = glass_ * (1 - reflectance);
  if (!front) {
    f.reflectance = Spectrum(glassiness_ * reflectance);
  } else if (reflectance > 0) {
    f.reflectance = Spectrum((1 - metallic) * (1 - spec_tint) * reflectance);
    if (metallic > 0) f.reflectance += schlick(base_color, c) * metallic;
    if (spec_tint > 0)
      f.reflectance += schlick(tint_ * square((eta - 1) / (eta + 1)), c) * ((1 - metallic) * spec_tint);
  }
  const float refracted = f.transmittance.mean(), all = refracted + f.reflectance.mean();
  f.refracting = refracted > 0 ? refracted / all : 0.0F;
  return f;
}

Principled::Lobes Principled::lobes(const Vec3f& wo, bool front) const noexcept {
  if (!front) return {0, 0, 1};
  const Facets f = facets(wo.z, ior, fresnel_dielectric(wo.z, ior).reflectance, true);
  // About what each scatters. The facets get something more, since those that lean reflect more; where they are all
  // that there is, they have all samples.
  const float diffuse = body_ * base_color.mean() + 0.2F * sheen * (1 - metallic);
  const float coat = clearcoat * schlick(Spectrum(kCoatReflectance), wo.z).r * wo.z;
  const float main = 0.05F + 0.95F * (f.reflectance + f.transmittance).mean();
  const float norm = 1 / (diffuse + coat + main);
  return {diffuse * norm, coat * norm, main * norm};
}

Spectrum Principled::diffuse(const Vec3f& wo, const Vec3f& wi, float c) const noexcept {
  Spectrum value;
  if (body_ > 0) {
    const float fi = schlick_weight(wi.z), fo = schlick_weight(wo.z), retro = 2 * roughness * c * c;
    float look = (1 - 0.5F * fi) * (1 - 0.5F * fo) + retro * (fi + fo + fi * fo * (retro - 1));
    if (flatness > 0) {
      const float subsurface = mix(1, 0.5F * retro, fi) * mix(1, 0.5F * retro, fo);
      look = mix(look, 1.25F * (subsurface * (1 / (wi.z + wo.z) - 0.5F) + 0.5F), flatness);
    }
    value = base_color * (body_ * look * kInvPi);
  }
  if (sheen > 0) value += mix(Spectrum(1), tint_, sheen_tint) * (sheen * (1 - metallic) * schlick_weight(c));
  return value * wi.z;
}

BsdfValue<float> Principled::eval_at(const Vec3f& wo, const Vec3f& wi, const Vec3f& m, bool front) const noexcept {
  const float eta = front ? ior : 1 / ior, c = std::min(1.0F, dot(wo, m));
  const Lobes lobe = lobes(wo, front);
  const Facets f = facets(c, eta, fresnel_dielectric(c, eta).reflectance, front);
  if (wi.z < 0) {
    if (!(f.refracting > 0)) return {};
    const FacetLobe<float> main = refracted(distribution, wo, wi, m, eta);
    return {f.transmittance * main.f_cos, lobe.facets * f.refracting * main.pdf};
  }
  const FacetLobe<float> main = reflected(distribution, wo, wi, m);
  BsdfValue<float> value{f.reflectance * main.f_cos, lobe.facets * (1 - f.refracting) * main.pdf};
  if (!front) return value;
  if (clearcoat > 0) {
    const float d = CoatDistribution{square(coat_alpha_)}.D(m);
    const float g = coat_masking(wo) * coat_masking(wi);
    value.f_cos += schlick(Spectrum(kCoatReflectance), c) * (0.25F * clearcoat * d * g * wi.z);
    value.pdf += lobe.clearcoat * d * m.z / (4 * c);
  }
  value.f_cos += diffuse(wo, wi, c);
  value.pdf += lobe.diffuse * cosine_hemisphere_pdf(wi.z);
  return value;
}

// Without transmission there is no inside: a back side that has the model at all, by twosided, is as a front.
BsdfValue<float> Principled::eval(const Vec3f& wo, const Vec3f& wi, bool front) const noexcept {
  front = front || !transmits;
  if (!(glassiness_ > 0) && (!front || !(wi.z > 0))) return {};
  const Optional<Vec3f> m = half_vector(wo, wi, front ? ior : 1 / ior);
  return m ? eval_at(wo, wi, *m, front) : BsdfValue<float>();
}

Optional<BsdfSample<float>> Principled::sample(const Vec3f& wo, bool front, double u_lobe, Point2f u) const noexcept {
  front = front || !transmits;
  if (!(glassiness_ > 0) && !front) return std::nullopt;
  const float eta = front ? ior : 1 / ior;
  const Lobes lobe = lobes(wo, front);
  Vec3f m, wi;
  bool refracts = false;
  if (u_lobe < lobe.diffuse) {
    wi = square_to_cosine_hemisphere(u);
    const Optional<Vec3f> between = half_vector(wo, wi, eta);
    if (!between) return std::nullopt;
    m = *between;
  } else {
    const double u_facet = (u_lobe - lobe.diffuse - lobe.clearcoat) / lobe.facets;
    m = u_facet < 0 ? CoatDistribution{square(coat_alpha_)}.sample(u) : distribution.sample(wo, u);
    const float c = std::min(1.0F, dot(wo, m));
    if (!(c > 0)) return std::nullopt;
    const auto [reflectance, cos_transmitted] = fresnel_dielectric(c, eta);
    refracts = u_facet >= 0 && u_facet < facets(c, eta, reflectance, front).refracting;
    wi = refracts ? m * (c / eta - cos_transmitted) - wo * (1 / eta) : m * (2 * c) - wo;
  }
  if (refracts ? !(wi.z < 0) : !(wi.z > 0)) return std::nullopt;
  const BsdfValue<float> value = eval_at(wo, wi, m, front);
  if (!(value.pdf > 0)) return std::nullopt;
  return BsdfSample<float>{wi, value.f_cos * (1 / value.pdf), value.pdf, false, refracts ? 1 / square(eta) : 1.0F};
}

Spectrum Principled::albedo(const Vec3f& wo, bool front) const noexcept {
  front = front || !transmits;
  const float eta = front ? ior : 1 / ior;
  const Facets f = facets(wo.z, eta, fresnel_dielectric(wo.z, eta).reflectance, front);
  if (!front) return f.reflectance + f.transmittance;
  const Spectrum rest = base_color * body_ + Spectrum(0.2F * sheen * (1 - metallic) + 0.04F * clearcoat);
  return f.reflectance + f.transmittance + rest;
}

}  // namespace equaltime
