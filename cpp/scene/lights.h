// Lights: all that emits, and how one of it is picked. An emissive triangle is a light of its own.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "math/optional.h"
#include "sampling/alias_table.h"
#include "sampling/sampler.h"
#include "scene/area_lights.h"
#include "scene/environment.h"
#include "scene/point_light.h"

namespace equaltime {

using AreaLight = std::variant<TriangleLight, RectangleLight, SphereLight, DiskLight>;
using Environment = std::variant<ConstantEnvironment, ImageEnvironment>;

enum class LightSelection : std::uint8_t { uniform, power };

/// Calls f with the kind of area light held. E prunes what the scene cannot hold.
template <auto E, class F>
[[nodiscard]] EQUALTIME_INLINE auto visit(const AreaLight& light, F&& f) noexcept {
  if constexpr (E.analytic_shapes) {
    if (const auto* sphere = std::get_if<SphereLight>(&light)) return f(*sphere);
    if (const auto* disk = std::get_if<DiskLight>(&light)) return f(*disk);
  }
  if (const auto* rectangle = std::get_if<RectangleLight>(&light)) return f(*rectangle);
  return f(*std::get_if<TriangleLight>(&light));
}

/// The lights of a scene, numbered: first area lights, then point lights, then the environment.
class Lights {
 public:
  Lights() = default;
  Lights(std::vector<AreaLight> area, std::vector<PointLight> points, std::optional<Environment> environment,
         double scene_radius);

  [[nodiscard]] std::uint32_t size() const noexcept { return size_; }
  [[nodiscard]] bool any_power() const noexcept { return !tables_[0].empty(); }
  [[nodiscard]] const std::optional<Environment>& environment() const noexcept { return environment_; }
  [[nodiscard]] bool has_points() const noexcept { return !points_.empty(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// One light, picked, then sampled at u as seen from the receiver; pdf includes the pick. Nothing if that light shows
  /// the receiver no front, which is a sample of value 0.
  template <auto E>
  [[nodiscard]] Optional<LightSample> sample(LightSelection selection, Vec3f receiver, const Sampler& sampler,
                                             std::uint32_t bounce, Point2f u) const noexcept;

  /// Density with which `sample` draws direction wi by the given area light, whose surface wi meets at `point`.
  template <auto E>
  [[nodiscard]] float area_pdf(LightSelection selection, std::uint32_t light, Vec3f receiver, Vec3f wi,
                               Vec3f point) const noexcept {
    return pick_pmf(selection, light) *
           visit<E>(area_[light], [&](const auto& l) noexcept { return l.pdf(receiver, wi, point); });
  }

  /// The environment towards wi, with the density (pick included) of `sample`. Call only with an environment.
  [[nodiscard]] LightValue environment_towards(LightSelection selection, Vec3f wi) const noexcept {
    LightValue value = std::visit([&](const auto& e) noexcept { return e.eval(wi); }, *environment_);
    value.pdf *= pick_pmf(selection, size_ - 1);
    return value;
  }

 private:
  [[nodiscard]] Optional<LightSample> sample_environment(const Sampler& sampler, std::uint32_t bounce,
                                                         float pmf) const noexcept;
  [[nodiscard]] float pick_pmf(LightSelection selection, std::uint32_t light) const noexcept {
    return tables_[static_cast<std::size_t>(selection)].pmf(light);
  }

  std::vector<AreaLight> area_;
  std::vector<PointLight> points_;
  std::optional<Environment> environment_;
  AliasTable tables_[2];  // by LightSelection
  std::uint32_t points_begin_ = 0, environment_begin_ = 0, size_ = 0;
};

template <auto E>
EQUALTIME_INLINE Optional<LightSample> Lights::sample(LightSelection selection, Vec3f receiver, const Sampler& sampler,
                                                      std::uint32_t bounce, Point2f u) const noexcept {
  const AliasTable& table = tables_[static_cast<std::size_t>(selection)];
  if (table.empty()) return std::nullopt;
  std::uint32_t light = 0;
  float pmf = 1;
  if (size_ > 1) {
    light = table.sample(sampler.bits(slot(BounceDimension::light_pick, bounce)));
    pmf = table.pmf(light);
  }
  if constexpr (E.environment)
    if (light >= environment_begin_) return sample_environment(sampler, bounce, pmf);
  if constexpr (E.point_lights)
    if (light >= points_begin_) return points_[light - points_begin_].sample(receiver, pmf);
  return visit<E>(area_[light], [&](const auto& l) noexcept { return l.sample(receiver, u, pmf); });
}

}  // namespace equaltime
