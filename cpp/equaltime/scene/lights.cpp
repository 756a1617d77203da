#include "equaltime/scene/lights.h"

#include <algorithm>
#include <functional>
#include <numbers>
#include <span>

namespace equaltime {

namespace {

/// Calls f with a light or an environment, of any type.
template <class Variant, class F>
decltype(auto) of(const Variant& light, F&& f) {
  return visit<kAllEffects>(light, f);
}

/// A light that is infinitely far away has no bounds.
bool is_distant(const DeltaLight& light) {
  return of(light, [](const auto& l) {
    return !requires { l.bounds(); };
  });
}

}  // namespace

Lights::Lights(std::vector<AreaLight> area, std::vector<DeltaLight> deltas, std::optional<Environment> environment,
               double scene_radius, std::vector<MovingLights> moving)
    : area_(std::move(area)),
      moving_(std::move(moving)),
      deltas_(std::move(deltas)),
      environment_(std::move(environment)) {
  const auto distant = std::stable_partition(deltas_.begin(), deltas_.end(), std::not_fn(is_distant));
  deltas_begin_ = static_cast<std::uint32_t>(area_.size());
  distant_begin_ = deltas_begin_ + static_cast<std::uint32_t>(distant - deltas_.begin());
  environment_begin_ = deltas_begin_ + static_cast<std::uint32_t>(deltas_.size());
  size_ = environment_begin_ + (environment_ ? 1 : 0);
  std::vector<double> power;
  power.reserve(size_);
  for (const AreaLight& light : area_) power.push_back(of(light, [](const auto& l) { return l.power(); }));
  for (const DeltaLight& light : deltas_)
    power.push_back(of(light, [=](const auto& l) { return l.power(scene_radius); }));
  if (environment_) {
    const double total = of(*environment_, [](const auto& e) { return e.total(); });
    power.push_back(total * std::numbers::pi * scene_radius * scene_radius);
  }
  tables_[static_cast<std::size_t>(LightSelection::power)] = AliasTable(power);
  distant_ = AliasTable(std::span(power).subspan(distant_begin_));
  // Uniform among lights of positive power: a dark light is never picked.
  for (double& p : power) p = p > 0 ? 1 : 0;
  tables_[static_cast<std::size_t>(LightSelection::uniform)] = AliasTable(power);
}

bool Lights::any_projects() const noexcept {
  return std::ranges::any_of(deltas_, [](const DeltaLight& light) {
    const auto* spot = std::get_if<SpotLight>(&light);
    return spot != nullptr && spot->slide();
  });
}

Optional<LightSample<float>> Lights::sample_delta(const PickedLight& pick, Vec3f receiver) const noexcept {
  const DeltaLight& light = deltas_[pick.light - deltas_begin_];
  return of(light,
            [&](const auto& l) noexcept -> Optional<LightSample<float>> { return l.sample(receiver, pick.pmf); });
}

Optional<LightSample<float>> Lights::sample_environment(EnvironmentSampling sampling, const Sampler& sampler,
                                                        std::uint32_t bounce, float pmf) const noexcept {
  const Point2d u = sampler.get_2d_precise(slot(BounceDecision::light_point, bounce));
  const EnvironmentSample e = of(*environment_, [&](const auto& env) noexcept { return env.sample(u, sampling); });
  if (!(e.value.pdf > 0)) return std::nullopt;
  return LightSample<float>{e.wi, e.value.radiance, e.value.pdf * pmf, 0, {}, true};
}

void Lights::prepare(LightSelection selection, EnvironmentSampling environment) const {
  if (environment_) of(*environment_, [environment](const auto& e) { e.prepare(environment); });
  if (selection != LightSelection::tree) return;
  std::call_once(lazy_tree_->once, [this] {
    std::vector<LightBounds> bounds;
    bounds.reserve(distant_begin_);
    for (const AreaLight& light : area_) bounds.push_back(of(light, [](const auto& l) { return l.bounds(); }));
    for (const MovingLights& lights : moving_)
      for (std::uint32_t i = 0; i < lights.local.size(); ++i)
        bounds[lights.first + i] = lights.bounds(lights.first + i);
    for (const DeltaLight& light : deltas_)
      of(light, [&](const auto& l) {
        if constexpr (requires { l.bounds(); }) bounds.push_back(l.bounds());
      });
    lazy_tree_->tree = LightTree(bounds);
    lazy_tree_->made.store(&lazy_tree_->tree, std::memory_order_release);
  });
}

// The tree holds finite lights only. Infinite lights get probability 1/2, or 1 if no finite light can reach the
// receiver. Probabilities by power would starve one side: indoors the infinite lights, under a bright sky the finite
// ones.

Optional<PickedLight> Lights::pick_by_tree(const LightSampleContext& receiver, std::uint64_t bits) const noexcept {
  constexpr int kSpare = 64 - LightTree::kUnitBits;
  if (distant_.empty()) return tree().pick(receiver, static_cast<std::int64_t>(bits >> kSpare));
  const bool may_be_near = tree().may_light(receiver);
  const float half = may_be_near ? 0.5F : 1.0F;
  if (may_be_near && bits >> 63 == 0) {
    auto pick = tree().pick(receiver, static_cast<std::int64_t>(bits << 1 >> kSpare));
    if (pick) pick->pmf *= half;
    return pick;
  }
  const std::uint32_t i = distant_.sample(may_be_near ? bits << 1 : bits);
  return PickedLight{distant_begin_ + i, half * distant_.pmf(i)};
}

float Lights::tree_pmf(std::uint32_t light, const LightSampleContext& receiver) const noexcept {
  if (size_ == 1) return 1;
  if (light >= distant_begin_) return (tree().may_light(receiver) ? 0.5F : 1.0F) * distant_.pmf(light - distant_begin_);
  return (distant_.empty() ? 1.0F : 0.5F) * tree().pmf(receiver, light);
}

std::size_t Lights::memory_bytes() const noexcept {
  std::size_t bytes = area_.size() * sizeof(AreaLight) + deltas_.size() * sizeof(DeltaLight);
  for (const AliasTable& table : tables_) bytes += table.memory_bytes();
  bytes += distant_.memory_bytes();
  for (const AreaLight& light : area_)
    bytes += of(light, [](const auto& l) -> std::size_t {
      if constexpr (requires { l.memory_bytes(); })
        return l.memory_bytes();
      else
        return 0;
    });
  if (const LightTree* made = lazy_tree_->made.load(std::memory_order_acquire)) bytes += made->memory_bytes();
  if (environment_) bytes += of(*environment_, [](const auto& e) { return e.memory_bytes(); });
  return bytes;
}

}  // namespace equaltime
