// Lights: all lights, and how one of them is picked. Each emissive triangle is a light of its own.
#pragma once

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/optional.h"
#include "equaltime/base/type_list.h"
#include "equaltime/lights/directional_light.h"
#include "equaltime/lights/environment.h"
#include "equaltime/lights/light_tree.h"
#include "equaltime/lights/point_light.h"
#include "equaltime/lights/spot_light.h"
#include "equaltime/sampling/alias_table.h"
#include "equaltime/sampling/sampler.h"
#include "equaltime/scene/moving_lights.h"

namespace equaltime {

/// Lights that no ray can hit: only light sampling finds them.
using DeltaLights = TypeList<PointLight<float>, SpotLight, DirectionalLight<float>>;
using DeltaLight = DeltaLights::Variant;
using Environments = TypeList<ConstantEnvironment, ImageEnvironment>;
using Environment = Environments::Variant;

/// Probability of a light: equal for all that have power, by power, or by the light tree, which also depends on the
/// receiver.
enum class LightSelection : std::uint8_t { uniform, power, tree };

/// A vertex that asks for light: where it is, and its random numbers. Pass it by value: a reference would force the
/// path's state into memory.
struct LightQuery {
  const LightSampleContext& receiver;
  const Sampler& sampler;
  std::uint32_t bounce;  // index of the vertex's random numbers
  Point2f u;             // its numbers for a point of a light
  float time;            // of the path, in [0, 1]
};

/// The lights of a scene. Their numbers are in this order: area lights, point and spot lights, directional lights, and
/// last the environment.
class Lights {
 public:
  Lights() = default;
  Lights(std::vector<AreaLight> area, std::vector<DeltaLight> deltas, std::optional<Environment> environment,
         double scene_radius, std::vector<MovingLights> moving = {});

  [[nodiscard]] std::uint32_t size() const noexcept { return size_; }
  /// The number of the environment, if there is one.
  [[nodiscard]] std::uint32_t environment_index() const noexcept { return size_ - 1; }
  /// Number of the first point, spot or directional light: no ray can hit these.
  [[nodiscard]] std::uint32_t first_delta() const noexcept { return deltas_begin_; }
  [[nodiscard]] bool any_power() const noexcept { return !tables_[0].empty(); }
  [[nodiscard]] const std::optional<Environment>& environment() const noexcept { return environment_; }
  /// The moving instance that carries an area light; null if the light does not move.
  [[nodiscard]] const MovingInstanceGeometry* moving_instance(std::uint32_t light) const noexcept {
    const MovingLights* lights = moving(light);
    return lights == nullptr ? nullptr : &lights->instance;
  }
  /// The spot light of a sample if it projects a slide; null otherwise.
  [[nodiscard]] const SpotLight* projector(const LightSample<float>& sample) const noexcept {
    if (!sample.delta || sample.infinite) return nullptr;
    const auto* spot = std::get_if<SpotLight>(&deltas_[sample.light - deltas_begin_]);
    return spot != nullptr && spot->slide() ? spot : nullptr;
  }
  [[nodiscard]] bool any_projects() const noexcept;
  [[nodiscard]] bool has_deltas() const noexcept { return !deltas_.empty(); }
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// Prepares the tables that a selection needs, once. Call it before `pick`; any number of threads may.
  void prepare(LightSelection selection, EnvironmentSampling environment) const;

  /// Picks one light and samples it as seen from a vertex. The pdf includes the pick's probability. Nothing if the
  /// light's front does not face the receiver: a sample of value 0.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample<float>> sample(LightSelection selection,
                                                                     EnvironmentSampling environment,
                                                                     LightQuery at) const noexcept {
    const auto picked = pick(selection, at);
    return picked ? sample<E>(*picked, environment, at) : std::nullopt;
  }
  /// The two steps of `sample`: `pick` selects a light, the next samples it. `pick` returns nothing if no light can
  /// reach the receiver.
  [[nodiscard]] EQUALTIME_INLINE Optional<PickedLight> pick(LightSelection selection, LightQuery at) const noexcept;
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample<float>> sample(PickedLight pick, EnvironmentSampling environment,
                                                                     LightQuery at) const noexcept;

  /// Whether the light can be sampled as directions: it is no point, and shows the receiver its front.
  template <Effects E>
  [[nodiscard]] bool has_directions(std::uint32_t light, const LightSampleContext& receiver, float time) const noexcept;
  /// Density of those directions at wi, whatever stands before the light; no pick is in it.
  template <Effects E>
  [[nodiscard]] float pdf_direction(std::uint32_t light, EnvironmentSampling environment,
                                    const LightSampleContext& receiver, Vec3f wi, float time) const noexcept;

  /// Density with which `sample` draws direction wi by the given area light, whose surface wi meets at `point`.
  template <Effects E>
  [[nodiscard]] float area_pdf(LightSelection selection, std::uint32_t light, const LightSampleContext& receiver,
                               Vec3f wi, Vec3f point, float time) const noexcept {
    return pick_pmf(selection, light, receiver) *
           visit_at<E>(light, time, [&](const auto& l) noexcept { return l.pdf(receiver.p, wi, point); });
  }

  /// The environment towards wi, with the density (pick included) of `sample`. Call only with an environment.
  [[nodiscard]] LightValue<float> environment_towards(LightSelection selection, EnvironmentSampling sampling,
                                                      const LightSampleContext& receiver, Vec3f wi) const noexcept {
    LightValue<float> value =
        visit<kAllEffects>(*environment_, [&](const auto& e) noexcept { return e.eval(wi, sampling); });
    value.pdf *= pick_pmf(selection, size_ - 1, receiver);
    return value;
  }

 private:
  /// The moving lights that a light is among; null if it stays where it is.
  [[nodiscard]] const MovingLights* moving(std::uint32_t light) const noexcept {
    const auto next = std::ranges::upper_bound(moving_, light, {}, &MovingLights::first);
    return next != moving_.begin() && std::prev(next)->has(light) ? &*std::prev(next) : nullptr;
  }
  /// Calls f with the kind of area light of a number, as it is at a time from 0 to 1.
  template <Effects E, class F>
  [[nodiscard]] EQUALTIME_INLINE auto visit_at(std::uint32_t light, [[maybe_unused]] float time, F&& f) const noexcept {
    if constexpr (E.motion)
      if (const MovingLights* lights = moving(light)) {
        const AreaLight now = lights->at(light, time);
        return visit<E>(now, f);
      }
    return visit<E>(area_[light], f);
  }
  /// The sample without its light's number.
  template <Effects E>
  [[nodiscard]] EQUALTIME_INLINE Optional<LightSample<float>> sample_picked(PickedLight pick,
                                                                            EnvironmentSampling environment,
                                                                            LightQuery at) const noexcept;
  [[nodiscard]] Optional<LightSample<float>> sample_delta(const PickedLight& pick, Vec3f receiver) const noexcept;
  [[nodiscard]] Optional<LightSample<float>> sample_environment(EnvironmentSampling sampling, const Sampler& sampler,
                                                                std::uint32_t bounce, float pmf) const noexcept;
  [[nodiscard]] EQUALTIME_INLINE float pick_pmf(LightSelection selection, std::uint32_t light,
                                                const LightSampleContext& receiver) const noexcept {
    if (selection == LightSelection::tree) return tree_pmf(light, receiver);
    return tables_[static_cast<std::size_t>(selection)].pmf(light);
  }
  [[nodiscard]] Optional<PickedLight> pick_by_tree(const LightSampleContext& receiver,
                                                   std::uint64_t bits) const noexcept;
  [[nodiscard]] float tree_pmf(std::uint32_t light, const LightSampleContext& receiver) const noexcept;
  [[nodiscard]] const LightTree& tree() const noexcept { return *lazy_tree_->made.load(std::memory_order_acquire); }

  /// The tree of all lights but the distant ones, for those strategies that ask for it.
  struct LazyTree {
    std::once_flag once;
    LightTree tree;
    std::atomic<const LightTree*> made{nullptr};
  };

  std::vector<AreaLight> area_;
  std::vector<MovingLights> moving_;  // in the order of their numbers
  std::vector<DeltaLight> deltas_;    // the distant ones last
  std::optional<Environment> environment_;
  AliasTable tables_[2];  // by LightSelection
  AliasTable distant_;    // directional lights and the environment, by power
  std::unique_ptr<LazyTree> lazy_tree_ = std::make_unique<LazyTree>();
  std::uint32_t deltas_begin_ = 0, distant_begin_ = 0, environment_begin_ = 0, size_ = 0;
};

EQUALTIME_INLINE Optional<PickedLight> Lights::pick(LightSelection selection, LightQuery at) const noexcept {
  if (!any_power()) return std::nullopt;
  if (size_ == 1) return PickedLight{0, 1};
  const std::uint64_t bits = at.sampler.bits(slot(BounceDecision::light_pick, at.bounce));
  if (selection == LightSelection::tree) return pick_by_tree(at.receiver, bits);
  const AliasTable& table = tables_[static_cast<std::size_t>(selection)];
  const std::uint32_t light = table.sample(bits);
  return PickedLight{light, table.pmf(light)};
}

template <Effects E>
EQUALTIME_INLINE Optional<LightSample<float>> Lights::sample(PickedLight pick, EnvironmentSampling environment,
                                                             LightQuery at) const noexcept {
  auto sample = sample_picked<E>(pick, environment, at);
  sample->light = pick.light;
  return sample;
}

template <Effects E>
EQUALTIME_INLINE Optional<LightSample<float>> Lights::sample_picked(PickedLight pick, EnvironmentSampling environment,
                                                                    LightQuery at) const noexcept {
  if constexpr (E.environment)
    if (pick.light >= environment_begin_) return sample_environment(environment, at.sampler, at.bounce, pick.pmf);
  if constexpr (E.point_lights)
    if (pick.light >= deltas_begin_) return sample_delta(pick, at.receiver.p);
  auto sample = visit_at<E>(pick.light, at.time, [&](const auto& l) noexcept {
    const Vec3f& p = at.receiver.p;
    if constexpr (requires { l.sample(p, Point2d{}, pick.pmf); })
      return l.sample(p, at.sampler.get_2d_precise(slot(BounceDecision::light_point, at.bounce)), pick.pmf);
    else
      return l.sample(p, at.u, pick.pmf);
  });
  if constexpr (E.motion)
    if (const MovingLights* lights = moving(pick.light)) sample = lights->with_offset(sample, at.time);
  return sample;
}

template <Effects E>
bool Lights::has_directions(std::uint32_t light, const LightSampleContext& receiver, float time) const noexcept {
  if (light >= deltas_begin_) return light >= environment_begin_;
  return visit_at<E>(light, time, [&](const auto& l) noexcept { return l.faces(receiver.p); });
}

template <Effects E>
float Lights::pdf_direction(std::uint32_t light, EnvironmentSampling environment, const LightSampleContext& receiver,
                            Vec3f wi, float time) const noexcept {
  if constexpr (E.environment)
    if (light >= environment_begin_)
      return visit<kAllEffects>(*environment_, [&](const auto& e) noexcept { return e.eval(wi, environment).pdf; });
  return visit_at<E>(light, time, [&](const auto& l) noexcept { return l.pdf_direction(receiver.p, wi); });
}

}  // namespace equaltime
