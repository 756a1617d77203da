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

std::size_t Lights::memory_bytes() const noexcept {
  std::size_t bytes = area_.size() * sizeof(AreaLight) + points_.size() * sizeof(PointLight);
  for (const AliasTable& table : tables_) bytes += table.memory_bytes();
  if (environment_) bytes += std::visit([](const auto& e) { return e.memory_bytes(); }, *environment_);
  return bytes;
}

}  // namespace equaltime
