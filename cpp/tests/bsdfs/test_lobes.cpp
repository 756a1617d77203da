// Lobes of a BSDF are picked with their exact probability, however small it is.
#include <cstdint>

#include "equaltime/base/effects.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/scene/shading.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

/// The interface between two nearly equal glasses, met head on.
Bsdf faint_glass() { return Dielectric<float>(DielectricDescription{.ior = 1.001}); }

Interaction head_on() {
  Interaction it{};
  it.anchor.n = it.wo = {0, 0, 1};
  it.frame = Frame::from_normal({0, 0, 1});
  it.front = true;
  return it;
}

TEST("samples refract or reflect by all bits of the number that picks") {
  const Bsdf glass = faint_glass();
  const Interaction it = head_on();
  const float reflectance = fresnel_dielectric(1.0F, std::get<Dielectric<float>>(glass).ior).reflectance;
  const Slot lobe = slot(BounceDecision::bsdf_lobe, 0);
  int told_apart = 0;  // what would be reflected by 24 bits and is not by all
  for (std::uint64_t index = 0; told_apart < 3; ++index) {
    const Sampler sampler = Sampler::at(SamplerKind::independent, 1, 0, index, 1);
    const float rounded_down = sampler.get_1d(lobe);
    const double u = sampler.get_1d_precise(lobe);
    if (rounded_down >= reflectance || u < reflectance) continue;
    const auto drawn = sample_bsdf<kAllEffects, true>(it, glass, sampler, 0, {});
    CHECK(drawn && !drawn->above);
    ++told_apart;
  }
}

}  // namespace

int main() { return check::run(); }
