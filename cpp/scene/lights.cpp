#include "scene/lights.h"

#include <numbers>

namespace equaltime {

Lights::Lights(std::vector<AreaLight> area, std::vector<PointLight> points, std::optional<Environment> environment,
               double scene_radius)
    : area_(std::move(area)), points_(std::move(points)), environment_(std::move(environment)) {
  points_begin_ = static_cast<std::uint32_t>(area_.size());
  environment_begin_ = points_begin_ + static_cast<std::uint32_t>(points_.size());
  size_ = environment_begin_ + (environment_ ? 1 : 0);
  std::vector<double> power;
  power.reserve(size_);
  for (const AreaLight& light : area_) power.push_back(std::visit([](const auto& l) { return l.power(); }, light));
  for (const PointLight& light : points_) power.push_back(light.power());
  if (environment_) {
    const double total = std::visit([](const auto& e) { return e.total(); }, *environment_);
    power.push_back(total * std::numbers::pi * scene_radius * scene_radius);
  }
  tables_[static_cast<std::size_t>(LightSelection::power)] = AliasTable(power);
  // Uniform among what shines at all: a dark light is never picked.
  for (double& p : power) p = p > 0 ? 1 : 0;
  tables_[static_cast<std::size_t>(LightSelection::uniform)] = AliasTable(power);
}

Optional<LightSample> Lights::sample_environment(const Sampler& sampler, std::uint32_t bounce,
                                                 float pmf) const noexcept {
  const Point2d u = sampler.get_2d_precise(slot(BounceDimension::light_point, bounce));
  const EnvironmentSample e = std::visit([&](const auto& env) noexcept { return env.sample(u); }, *environment_);
  if (!(e.value.pdf > 0)) return std::nullopt;
  return LightSample{e.wi, e.value.radiance, e.value.pdf * pmf, 0, {}, true};
}

void Lights::prepare(LightSelection selection) const {
  if (selection != LightSelection::tree) return;
  std::call_once(lazy_tree_->once, [this] {
    std::vector<EmitterBounds> bounds;
    bounds.reserve(environment_begin_);
    for (const AreaLight& light : area_) bounds.push_back(std::visit([](const auto& l) { return l.bounds(); }, light));
    for (const PointLight& light : points_) bounds.push_back(light.bounds());
    lazy_tree_->tree = LightTree(bounds);
    lazy_tree_->made.store(&lazy_tree_->tree, std::memory_order_release);
  });
}

// The environment stands beside the tree: it gets half of all picks, or every one where no other light may reach the
// receiver. By its power it would get all but none of them indoors, or leave none to a lamp under the sky.

Optional<LightPick> Lights::pick_by_tree(const Receiver& receiver, std::uint64_t bits) const noexcept {
  constexpr int kSpare = 64 - LightTree::kPlaceBits;
  if (!environment_) return tree().pick(receiver, static_cast<std::int64_t>(bits >> kSpare));
  if (!tree().may_light(receiver)) return LightPick{environment_begin_, 1};
  if (bits >> 63 != 0) return LightPick{environment_begin_, 0.5F};
  auto pick = tree().pick(receiver, static_cast<std::int64_t>(bits << 1 >> kSpare));
  if (pick) pick->pmf *= 0.5F;
  return pick;
}

float Lights::tree_pmf(std::uint32_t light, const Receiver& receiver) const noexcept {
  if (size_ == 1) return 1;
  if (light >= environment_begin_) return tree().may_light(receiver) ? 0.5F : 1.0F;
  return (environment_ ? 0.5F : 1.0F) * tree().pmf(receiver, light);
}

std::size_t Lights::memory_bytes() const noexcept {
  std::size_t bytes = area_.size() * sizeof(AreaLight) + points_.size() * sizeof(PointLight);
  for (const AliasTable& table : tables_) bytes += table.memory_bytes();
  if (const LightTree* made = lazy_tree_->made.load(std::memory_order_acquire)) bytes += made->memory_bytes();
  if (environment_) bytes += std::visit([](const auto& e) { return e.memory_bytes(); }, *environment_);
  return bytes;
}

}  // namespace equaltime
