// Breakdown of an image's light. It traces the paths of a render, and groups each contribution five times: by the
// length of the path, by the sampling technique, by the last BSDF, by the last surface, and by the light. Each grouping
// adds up to the image.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/render/renderer.h"
#include "equaltime/transport/observer.h"

namespace equaltime {

/// The parts of a scene's light, numbered: lengths of paths, ways to find light, BSDFs, groups of surfaces, lights.
class BreakdownParts {
 public:
  static constexpr std::uint32_t kLengths = 16;  // the last has all that are longer
  static constexpr std::uint32_t kWays = 3;      // seen by the camera, met by a scattered ray, aimed at
  static constexpr std::uint32_t kMostLights =
      24;  // beside the environment; if there are more, the last part has the others

  /// `surface_groups`: the group of each shape of the scene, from 0; without any, all shapes are one group.
  BreakdownParts(const Scene& scene, std::span<const std::uint32_t> surface_groups);

  [[nodiscard]] static std::uint32_t length(int depth) noexcept {
    return std::min(static_cast<std::uint32_t>(depth), kLengths) - 1;
  }
  [[nodiscard]] static constexpr std::uint32_t way(std::uint32_t i) noexcept { return kLengths + i; }
  [[nodiscard]] static constexpr std::uint32_t bsdf(std::uint32_t i) noexcept { return kLengths + kWays + i; }
  /// Returns the number of a BSDF or phase function; 0 stands for none, and phase functions come last.
  [[nodiscard]] static std::uint32_t number(Scatterer s) noexcept {
    return 1 + static_cast<std::uint32_t>(s.bsdf != nullptr ? s.bsdf->index() : Bsdfs::size + s.phase->index());
  }
  [[nodiscard]] std::uint32_t light(std::uint32_t number) const noexcept { return light_part_[number]; }
  /// Parts of light by what scattered it last: nothing, a medium, or the surface of a shape.
  [[nodiscard]] std::uint32_t unscattered() const noexcept { return first_surface_; }
  [[nodiscard]] std::uint32_t medium() const noexcept { return first_surface_ + 1; }
  [[nodiscard]] std::uint32_t surface(std::uint32_t shape) const noexcept {
    return first_surface_ + 2 + (surface_groups_.empty() ? 0 : surface_groups_[shape]);
  }
  [[nodiscard]] std::uint32_t count() const noexcept { return static_cast<std::uint32_t>(names_.size()); }

  /// Names of a part, such as {"length", "3"}, {"surface", "7"}, {"light", "shape 12"}: groups of surfaces by their
  /// number, lights by their shape, others by their order.
  struct Name {
    std::string kind, what;
  };
  [[nodiscard]] const std::vector<Name>& names() const noexcept { return names_; }

 private:
  void name_surfaces(const Scene& scene, std::span<const std::uint32_t> groups);
  void name_lights(const Scene& scene);

  std::vector<Name> names_;
  std::uint32_t first_surface_ = 0;            // part of light that nothing has scattered
  std::vector<std::uint32_t> surface_groups_;  // of each surface of the scene, or none
  std::vector<std::uint32_t> light_part_;      // of each light
};

/// Collects the contributions of a path, so that they count only if the path's sample does.
class BreakdownObserver : public PathObserver {
 public:
  static constexpr bool allocates = true;

  BreakdownObserver(const BreakdownParts& parts, bool count_null_interfaces) noexcept
      : parts_(parts), count_null_interfaces_(count_null_interfaces) {}

  /// Adds the contributions of the last path to the sums of its pixel: three channels a part.
  void add_to(std::span<double> pixel) const noexcept;

  void on(const event::PathStarted& path) noexcept {
    weight_ = static_cast<double>(path.filter_weight), bsdf_ = 0, surface_ = parts_.unscattered();
    added_.clear();
  }
  void on(const event::RayHit& hit) noexcept { hit_ = hit.it != nullptr ? hit.it->shape : kNone; }
  void on(const event::VertexReached& at) noexcept {
    bsdf_ = BreakdownParts::number(at.scatterer);
    surface_ = at.scatterer.phase != nullptr ? parts_.medium() : parts_.surface(hit_);
  }
  void on(const event::PathSplit&) noexcept { split_at_ = surface_; }
  void on(const event::CopyResumed& at) noexcept { bsdf_ = BreakdownParts::number(at.scatterer), surface_ = split_at_; }
  void on(const event::LightSampled& sampled) noexcept {
    aimed_at_ = sampled.light.light;
    crossed_ = -1;
  }
  void on(const event::ShadowRayHit&) noexcept {
    if (count_null_interfaces_) ++crossed_;
  }
  void on(const event::EmissionAdded& added) {
    if (!added.L.is_black()) add(added.L, added.depth, bsdf_ == 0 ? 0 : 1, added.light);
  }
  void on(const event::DirectLightAdded& added) {
    if (!added.L.is_black()) add(added.L, added.depth + std::max(crossed_, 0), 2, aimed_at_);
  }

 private:
  /// Light that a path adds, with its part of each kind.
  struct Contribution {
    Spectrum L;
    std::array<std::uint32_t, 5> parts;
  };
  void add(const Spectrum& L, int depth, std::uint32_t way, std::uint32_t light);

  const BreakdownParts& parts_;
  std::vector<Contribution> added_;  // by the last path
  bool count_null_interfaces_;
  double weight_ = 1;
  std::uint32_t bsdf_ = 0, aimed_at_ = 0;
  std::uint32_t hit_ = kNone;                 // shape that the last ray met
  std::uint32_t surface_ = 0, split_at_ = 0;  // parts: of the last vertex, and of the one where the path has copies
  int crossed_ = 0;
};

struct LightBreakdown {
  BreakdownParts parts;
  std::uint32_t height, width;
  std::uint32_t kept;        // of the parts, so many from the first on
  std::vector<float> means;  // (height, width, kept, 3), in the user's units
};

/// The mean of `samples` samples of every pixel, part by part, or only by lengths of paths: those of a render with the
/// same options. `surface_groups` has the group of each shape of the scene, from 0; if it is empty, all shapes are one
/// group. Samples that are not finite are left out, as they are of a film. `poll` is called about every 50 ms by the
/// calling thread and ends it all by throwing.
[[nodiscard]] LightBreakdown break_down_light(std::shared_ptr<const Scene> scene, const Settings& settings,
                                              const RenderOptions& options, std::uint64_t samples,
                                              bool only_lengths = false,
                                              std::span<const std::uint32_t> surface_groups = {},
                                              const Poll& poll = {});

}  // namespace equaltime
