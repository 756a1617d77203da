// Shading: a BSDF at a point, in world directions. The local models evaluate by the shading normal; which side of the
// surface a direction is on is decided by the geometric one, alike in eval and sample, so that no light leaks and all
// techniques integrate the same function.
#pragma once

#include <type_traits>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/bsdfs/bsdf.h"
#include "equaltime/lights/light_types.h"
#include "equaltime/media/phase_function.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/shapes/interaction.h"

namespace equaltime {

/// What scatters light at a vertex: the BSDF of a surface, or the phase function of a medium.
struct Scatterer {
  const Bsdf* bsdf = nullptr;
  const PhaseFunction* phase = nullptr;

  Scatterer() noexcept = default;
  Scatterer(const Bsdf& of_surface) noexcept : bsdf(&of_surface) {}
  Scatterer(const PhaseFunction& of_medium) noexcept : phase(&of_medium) {}

  /// Glass without thickness, which lets a part of the light go straight on.
  [[nodiscard]] bool is_thin() const noexcept {
    return bsdf != nullptr && std::holds_alternative<ThinDielectric<float>>(*bsdf);
  }
  [[nodiscard]] const char* name() const noexcept {
    return bsdf != nullptr ? Bsdfs::names[bsdf->index()] : PhaseFunctions::names[phase->index()];
  }
};

/// Calls f with the model that scatters, of those that a kernel for the effects can meet.
template <Effects E, class F>
[[nodiscard]] EQUALTIME_INLINE decltype(auto) visit(Scatterer scatterer, F&& f) noexcept {
  if constexpr (E.media)
    if (scatterer.phase != nullptr) return visit<E>(*scatterer.phase, f);
  return visit<E>(*scatterer.bsdf, f);
}

/// The value of a BSDF for a pair of directions, and on which side of the surface the second is.
struct ScatterValue {
  BsdfValue<float> value;
  bool above = false;
};

/// A sampled direction in world space, with the rest of BsdfSample.
struct ScatterSample {
  Vec3f wi;
  bool above;  // on the side of the geometric normal
  Spectrum weight;
  float pdf;
  bool delta;
  float eta_scale;
};

namespace detail {
/// The shading and the geometric normal agree on which side of the surface a direction is.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE bool same_side(const Interaction& it, const Vec3f& world, const Vec3f& local) noexcept {
  if constexpr (E.smooth_normals || E.normal_maps)
    if (it.smooth) return (dot(it.anchor.n, world) > 0) == (local.z > 0);
  return true;
}

/// What a perturbed normal lets through of the light of a direction, so that it darkens softly towards where the
/// surface ends it (Conty Estevez et al. 2019, section 4).
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE Spectrum shadowed(const Interaction& it, const Vec3f& wi, const Spectrum& f) noexcept {
  if constexpr (E.normal_maps) {
    if (it.terminator_alpha2 == 0) return f;
    const float cos2 = square(dot(it.unperturbed_normal, wi));
    return f * (2 / (1 + std::sqrt(1 + it.terminator_alpha2 * (1 - cos2) / cos2)));
  }
  return f;
}
}  // namespace detail

/// f(wo, wi)·|cosθi| and pdf of wi.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE ScatterValue eval_bsdf(const Interaction& it, Scatterer scatterer,
                                                      const Vec3f& wi) noexcept {
  Vec3f wo = it.frame.to_local(it.wo);
  Vec3f local = it.frame.to_local(wi);
  if (!(wo.z > 0) || !detail::same_side<E>(it, wi, local)) return {};
  BsdfValue<float> value =
      visit<E>(scatterer, [&](const auto& model) noexcept { return model.eval(wo, local, it.front); });
  return {{detail::shadowed<E>(it, wi, value.f_cos), value.pdf}, local.z > 0};
}

/// A direction drawn from the BSDF; u is for the place within a lobe, the number that picks one is taken if needed.
/// `kDelta` is what `is_delta` says of the scatterer, so that each branch of a caller compiles its own models alone.
/// They are few, and inlined: a sample that comes from a call passes through memory.
template <Effects E, bool kDelta>
[[nodiscard]] EQUALTIME_INLINE Optional<ScatterSample> sample_bsdf(const Interaction& it, Scatterer scatterer,
                                                                   const Sampler& sampler, std::uint32_t bounce,
                                                                   Point2f u) noexcept {
  Vec3f wo = it.frame.to_local(it.wo);
  if (!(wo.z > 0)) return std::nullopt;
  auto s = visit<E>(
      scatterer, [&](const auto& model) __attribute__((always_inline))->Optional<BsdfSample<float>> {
        using Model = std::decay_t<decltype(model)>;
        if constexpr (Model::is_delta != kDelta) __builtin_unreachable();
        double u_lobe = 0;
        if constexpr (Model::picks_lobe) u_lobe = sampler.get_1d_precise(slot(BounceDecision::bsdf_lobe, bounce));
        return model.sample(wo, it.front, u_lobe, u);
      });
  if (!s) return std::nullopt;
  Vec3f wi = it.frame.to_world(s->wi);
  if (!detail::same_side<E>(it, wi, s->wi)) return std::nullopt;
  return ScatterSample{wi, s->wi.z > 0, detail::shadowed<E>(it, wi, s->weight), s->pdf, s->delta, s->eta_scale};
}

/// What the BSDF lets go straight on towards -wo: of glass without thickness, what its samples bring on the mean. None
/// of what others scatter, be it in that direction.
template <Effects E>
[[nodiscard]] Spectrum straight_through(const Interaction& it, const Bsdf& bsdf) noexcept {
  const auto* pane = std::get_if<ThinDielectric<float>>(&bsdf);
  const Vec3f wo = it.frame.to_local(it.wo);
  if (pane == nullptr || !(wo.z > 0) || !detail::same_side<E>(it, -it.wo, -wo)) return {};
  return detail::shadowed<E>(it, -it.wo, pane->transmittance(wo));
}

/// Whether the BSDF scatters to the other side of the surface too.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE bool transmits(Scatterer scatterer) noexcept {
  return visit<E>(scatterer, [](const auto& model) noexcept { return model.transmits; });
}

/// The probability that a sample of the BSDF is a discrete direction, if it has others too.
template <Effects E>
[[nodiscard]] float delta_probability(const Interaction& it, Scatterer scatterer) noexcept {
  const Vec3f wo = it.frame.to_local(it.wo);
  return visit<E>(scatterer, [&](const auto& model) noexcept {
    if constexpr (requires { model.delta_probability(wo, it.front); })
      return model.delta_probability(wo, it.front);
    else
      return 0.0F;
  });
}

/// A direction that knows nothing of the BSDF: uniform over the hemisphere of the shading normal, or over the sphere if
/// the BSDF transmits. It never meets discrete directions: a BSDF that has some beside others draws those itself, and
/// one that has no others must not come here.
template <Effects E>
[[nodiscard]] Optional<ScatterSample> sample_uniform(const Interaction& it, Scatterer scatterer, const Sampler& sampler,
                                                     std::uint32_t bounce, Point2f u) noexcept {
  const float discrete = delta_probability<E>(it, scatterer);
  if (discrete > 0 && sampler.get_1d_precise(slot(BounceDecision::bsdf_lobe, bounce)) < discrete)
    return sample_bsdf<E, false>(it, scatterer, sampler, bounce, u);
  const bool sphere = transmits<E>(scatterer);
  const Vec3f wi = it.frame.to_world(sphere ? square_to_uniform_sphere(u) : square_to_uniform_hemisphere(u));
  const float pdf = (sphere ? kUniformSpherePdf : kUniformHemispherePdf) * (1 - discrete);
  const auto [value, above] = eval_bsdf<E>(it, scatterer, wi);
  if (value.f_cos.is_black()) return std::nullopt;
  return ScatterSample{wi, above, value.f_cos * (1 / pdf), pdf, false, 1};
}

/// The share of light that the BSDF scatters, by colour; radiance's compression by refraction is not in it.
template <Effects E>
[[nodiscard]] Spectrum albedo(const Interaction& it, Scatterer scatterer) noexcept {
  const Vec3f wo = it.frame.to_local(it.wo);
  return visit<E>(scatterer, [&](const auto& model) noexcept { return model.albedo(wo, it.front); });
}

/// Whether the BSDF scatters into a discrete set of directions only.
template <Effects E>
[[nodiscard]] bool is_delta(Scatterer scatterer) noexcept {
  return visit<E>(scatterer, [](const auto& model) noexcept { return model.is_delta; });
}

/// The point as lights see it.
template <Effects E>
[[nodiscard]] EQUALTIME_INLINE LightSampleContext receiver_at(const Interaction& it, Scatterer scatterer) noexcept {
  return {it.anchor.p, it.frame.n, !transmits<E>(scatterer)};
}

}  // namespace equaltime
