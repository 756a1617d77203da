#include "equaltime/bsdfs/bsdf.h"

namespace equaltime {

Diffuse::Diffuse(const DiffuseDescription& d) noexcept : reflectance(spectrum(d.reflectance)) {}
Conductor::Conductor(const ConductorDescription& d) noexcept
    : eta(spectrum(d.eta)), k(spectrum(d.k)), specular_reflectance(spectrum(d.specular_reflectance)) {}
RoughConductor::RoughConductor(const RoughConductorDescription& d) noexcept
    : distribution(d.model, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
      eta(spectrum(d.eta)),
      k(spectrum(d.k)),
      specular_reflectance(spectrum(d.specular_reflectance)) {}
Dielectric::Dielectric(const DielectricDescription& d) noexcept
    : ior(static_cast<float>(d.ior)),
      specular_reflectance(spectrum(d.specular_reflectance)),
      specular_transmittance(spectrum(d.specular_transmittance)) {}
ThinDielectric::ThinDielectric(const ThinDielectricDescription& d) noexcept
    : ior(static_cast<float>(d.ior)),
      specular_reflectance(spectrum(d.specular_reflectance)),
      specular_transmittance(spectrum(d.specular_transmittance)) {}
Plastic::Plastic(const PlasticDescription& d) noexcept
    : ior(static_cast<float>(d.ior)),
      nonlinear(d.nonlinear),
      diffuse_reflectance(spectrum(d.diffuse_reflectance)),
      specular_reflectance(spectrum(d.specular_reflectance)),
      internal_(fresnel_diffuse(1 / ior)),
      leaving_(square(ior) * (1 - internal_)) {
  derive();
}
RoughPlastic::RoughPlastic(const RoughPlasticDescription& d)
    : distribution(d.model, static_cast<float>(d.alpha), static_cast<float>(d.alpha)),
      ior(static_cast<float>(d.plastic.ior)),
      nonlinear(d.plastic.nonlinear),
      diffuse_reflectance(spectrum(d.plastic.diffuse_reflectance)),
      specular_reflectance(spectrum(d.plastic.specular_reflectance)),
      transmittance_(distribution, ior) {
  derive();
}
RoughDielectric::RoughDielectric(const RoughDielectricDescription& d) noexcept
    : distribution(d.model, static_cast<float>(d.alpha_u), static_cast<float>(d.alpha_v)),
      ior(static_cast<float>(d.dielectric.ior)),
      specular_reflectance(spectrum(d.dielectric.specular_reflectance)),
      specular_transmittance(spectrum(d.dielectric.specular_transmittance)) {}
/// Stands for an index of glass that is 1 in float32, whose facets would bend nothing: the same as Mitsuba's.
constexpr float kLeastContrast = 1.001F;
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

bool is_anisotropic(const Bsdf& bsdf) noexcept {
  return std::visit(
      [](const auto& model) noexcept {
        if constexpr (requires { model.distribution; })
          return model.distribution.anisotropic();
        else
          return false;
      },
      bsdf);
}

}  // namespace equaltime
