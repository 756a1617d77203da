#include "scene/lights.h"

#include <numbers>

namespace equaltime {

Lights::Lights(std::vector<AreaLight> area, std::vector<PointLight> points, std::optional<Environment> environment,
               double scene_radius)
    : area_(std::move(area)), points_(std::move(points)), environment_(std::move(environment)) {
  std::vector<double> power;
  power.reserve(size());
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

std::size_t Lights::memory_bytes() const noexcept {
  std::size_t bytes = area_.size() * sizeof(AreaLight) + points_.size() * sizeof(PointLight);
  for (const AliasTable& table : tables_) bytes += table.memory_bytes();
  if (environment_) bytes += std::visit([](const auto& e) { return e.memory_bytes(); }, *environment_);
  return bytes;
}

}  // namespace equaltime
