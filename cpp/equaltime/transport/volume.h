// Media along a path: where a medium scatters it, and the transmittance of shadow rays through media and null surfaces.
// A surface that bounds media sets the ray's medium. Other surfaces leave it unchanged, as in Mitsuba. Among
// dielectrics with priorities, the one of the highest priority sets it (scene/nesting.h). Distances are computed in
// float64 from the path's made position. The origin of Embree's ray is offset from it, in a dense medium by many mean
// free paths.
#pragma once

#include <limits>

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/nearby.h"
#include "equaltime/transport/shadow.h"

namespace equaltime {

namespace detail {
/// A vertex in a medium. Rays from it begin at `p`.
[[nodiscard]] EQUALTIME_INLINE Interaction vertex_in_medium(const Ray& ray, const Vec3f& p) noexcept {
  Interaction it{};
  it.anchor = {p, -ray.direction, 0};
  it.wo = -ray.direction;
  it.frame = Frame::from_normal(it.wo);
  it.shape = it.primitive = it.instance = kNone;
  it.front = true;
  return it;
}
}  // namespace detail

/// The medium at a place: the dielectrics that hold it, and the medium outside of them. Shadow rays copy it. Kernels
/// without media have this empty one.
template <Effects E>
class MediumState {
 public:
  void leave(const SceneGeometry&, const Interaction&, bool) const noexcept {}
  [[nodiscard]] static constexpr bool hides(const SceneGeometry&, std::uint32_t) noexcept { return false; }
  [[nodiscard]] static const Bsdf& with_exterior(const Scene&, const Interaction&, const Bsdf& bsdf,
                                                 std::optional<Bsdf>&) noexcept {
    return bsdf;
  }
};

template <Effects E>
requires(E.media) class MediumState<E> {
 public:
  /// State at the origin of a camera ray.
  MediumState(const Scene& scene, const Ray& camera_ray, [[maybe_unused]] float time) noexcept
      : dielectrics_(scene.volumes.nesting.fixed.dielectrics),
        exterior_medium_(scene.volumes.nesting.fixed.medium),
        position_(camera_ray.origin) {
    if constexpr (E.motion)
      if (!scene.volumes.nesting.time_dependent.empty()) {
        const CameraMedium now = scene.camera_medium(time);
        dielectrics_ = now.dielectrics, exterior_medium_ = now.medium;
      }
  }

  /// Updates the state as the path leaves a vertex. `above`: on the side of the geometric normal.
  void leave(const SceneGeometry& geometry, const Interaction& it, bool above) noexcept {
    if (it.in_medium()) return;
    const SurfaceMedia& media = geometry.surfaces[it.shape].media;
    const bool leaves_by_front = above == it.front;
    if (media.rank != kNoRank) {
      dielectrics_ = leaves_by_front ? others(media.rank) : dielectrics_ | dielectric_bit(media.rank);
      if (!leaves_by_front || dielectrics_ != 0) return;
    }
    if (media.sets_medium) exterior_medium_ = media.sides[leaves_by_front ? 0 : 1];
  }
  /// Whether a dielectric of higher priority holds the path where it meets the shape, and hides its surface.
  [[nodiscard]] bool hides(const SceneGeometry& geometry, std::uint32_t shape) const noexcept {
    const std::uint8_t rank = geometry.surfaces[shape].media.rank;
    return rank != kNoRank && others(rank) != 0 && top_rank(others(rank)) > rank;
  }
  /// The surface's BSDF, with its index relative to the exterior dielectric if there is one. `made` stores such a BSDF.
  [[nodiscard]] const Bsdf& with_exterior(const Scene& scene, const Interaction& it, const Bsdf& bsdf,
                                          std::optional<Bsdf>& made) const noexcept {
    const std::uint8_t rank = scene.geometry.surfaces[it.shape].media.rank;
    if (rank == kNoRank || others(rank) == 0) return bsdf;
    const Bsdf changed = with_exterior_ior(bsdf, scene.volumes.nesting.dielectrics[index(others(rank))].ior);
    return made.emplace(changed);
  }
  /// Transmittance of the medium along a shadow ray, up to the surface that it hits or else the light. Moves the path's
  /// position to that surface.
  template <Observer O>
  [[nodiscard]] Spectrum transmittance_along(const Scene& scene, const Ray& shadow, const ExactIntersection& hit,
                                             const LightSample<float>& light, float time,
                                             O& observer) noexcept(!O::allocates) {
    const std::uint32_t here = medium_index(scene.volumes);
    const Vec3d from = position_;
    if (hit.it) position_ = hit.point;
    if (here == kNone) return Spectrum(1);
    const Medium& medium = scene.volumes.media[here];
    if (hit.it)
      return medium.transmittance(distance_along(from, shadow.direction, hit) * length(Vec3d(shadow.direction)));
    if (light.infinite) return medium.transmittance(std::numeric_limits<double>::infinity());
    return medium.transmittance(distance_to(scene.geometry, medium, from, shadow, light, time, observer));
  }

  /// Index of the medium at the path's position; kNone: vacuum.
  [[nodiscard]] std::uint32_t medium_index(const Volumes& volumes) const noexcept {
    return dielectrics_ == 0 ? exterior_medium_ : volumes.nesting.dielectrics[index(dielectrics_)].medium;
  }
  [[nodiscard]] const Vec3d& position() const noexcept { return position_; }
  void move_to(const Vec3d& position) noexcept { position_ = position; }

 private:
  /// Largest error of an emitter's distance, in mean free paths: transmittance is then off by 0.01 %.
  static constexpr float kMaxError = 1e-4F;

  /// The distance of a light sample that nothing occludes. In dense media its rounded point is not good enough, and a
  /// ray finds the exact one.
  template <Observer O>
  [[nodiscard, gnu::noinline]] static double distance_to(const SceneGeometry& geometry, const Medium& medium,
                                                         const Vec3d& from, const Ray& shadow,
                                                         const LightSample<float>& light, [[maybe_unused]] float time,
                                                         O& observer) noexcept(!O::allocates) {
    if (!light.delta && medium.sigma_t.max_component() * light.target.offset > kMaxError) {
      const Ray ray{shadow.origin, light.wi};
      const ExactIntersection emitter = closest<E>(geometry, ray, time, observer);
      tell<event::EmitterRayTraced>(observer, ray, time);
      if (emitter.it && geometry.emits(*emitter.it) && geometry.light_of(*emitter.it) == light.light)
        return distance_along(from, light.wi, emitter);
    }
    return length(Vec3d(light.target.p) - from);
  }
  [[nodiscard]] static std::size_t index(DielectricSet dielectrics) noexcept {
    return static_cast<std::size_t>(top_rank(dielectrics));
  }
  [[nodiscard]] DielectricSet others(std::uint8_t rank) const noexcept { return dielectrics_ & ~dielectric_bit(rank); }

  DielectricSet dielectrics_;      // that hold the path
  std::uint32_t exterior_medium_;  // outside all dielectrics; kNone: vacuum
  Vec3d position_;                 // last vertex of the path, or the camera
};

/// The medium at the end of a path, with the surfaces close to it, which only the path itself needs.
template <Effects E>
class PathMediumState {
 public:
  PathMediumState(const Scene&, const Ray&, float) noexcept {}
  [[nodiscard]] static MediumState<E> here() noexcept { return {}; }
  [[nodiscard]] const PhaseFunction* sample_distance(const Scene&, const Ray&, const Sampler&, std::uint32_t,
                                                     const Spectrum&, const SurfaceIntersection<E>&) const noexcept {
    return nullptr;
  }
  void leave(const Scene&, const Interaction&, bool) const noexcept {}
};

template <Effects E>
requires(E.media) class PathMediumState<E> {
 public:
  /// State at the origin of a camera ray.
  PathMediumState(const Scene& scene, const Ray& camera_ray, float time) noexcept : here_(scene, camera_ray, time) {}

  [[nodiscard]] const MediumState<E>& here() const noexcept { return here_; }

  /// Samples a distance along the ray, and updates the throughput `beta`. If the medium scatters, `ahead` becomes the
  /// vertex there, and its phase function is returned; null otherwise.
  [[nodiscard]] EQUALTIME_INLINE const PhaseFunction* sample_distance(const Scene& scene, const Ray& ray,
                                                                      const Sampler& sampler, std::uint32_t bounce,
                                                                      Spectrum& beta,
                                                                      ExactIntersection& ahead) noexcept {
    const std::uint32_t medium_here = here_.medium_index(scene.volumes);
    const Vec3d from = here_.position();
    Optional<Interaction>& it = ahead.it;
    if (it) here_.move_to(ahead.point);
    if (medium_here == kNone || beta.is_black()) return nullptr;
    const Medium& medium = scene.volumes.media[medium_here];
    const Point2d u = sampler.get_2d_precise(slot(BounceDecision::medium, bounce));
    const double free = it ? distance_along(from, ray.direction, ahead) : std::numeric_limits<double>::infinity();
    const DistanceSample flight = medium.sample(beta, free, u);
    beta *= flight.weight;
    if (!flight.scattered) return nullptr;
    const Vec3d vertex = from + Vec3d(ray.direction) * flight.distance;
    const float height = it ? static_cast<float>(flight.distance - free) * dot(ray.direction, it->anchor.n) : 0;
    here_.move_to(vertex);
    it = detail::vertex_in_medium(ray, nearby_.begin(vertex, ahead, height));
    return &scene.volumes.phases[medium_here];
  }
  /// Updates the state as the path leaves a vertex. `above`: on the side of the geometric normal.
  void leave(const Scene& scene, const Interaction& it, bool above) noexcept {
    if (it.in_medium()) return;
    here_.leave(scene.geometry, it, above);
    if (here_.medium_index(scene.volumes) == kNone)
      nearby_.clear();
    else
      nearby_.leave(here_.position(), above ? it.anchor.n : -it.anchor.n, it.anchor.offset);
  }

 private:
  MediumState<E> here_;
  NearbySurfaces nearby_;
};

/// Fraction of a light's radiance that reaches the vertex through media and at most `crossings` surfaces. `above`: the
/// light is on the side of the vertex's geometric normal.
template <Effects E, Observer O>
[[nodiscard]] Spectrum shadow_transmittance(const Scene& scene, const Interaction& vertex, bool above,
                                            MediumState<E> media, const LightSample<float>& light, int crossings,
                                            float time, O& observer) noexcept(!O::allocates) {
  const bool glass_passes = shines_through_glass(scene, light);
  // In media, the exact distance to the surface matters too.
  const bool may_pass = scene.appearance.lets_light_pass || (E.media && !scene.volumes.media.empty());
  Spectrum transmittance(1);
  Interaction from = vertex;
  for (;;) {
    media.leave(scene.geometry, from, above);
    const Ray shadow = shadow_ray(from, above, light);
    if (!may_pass && occluded<E>(scene.geometry, shadow, time, observer)) return {};
    auto hit = may_pass ? closest_occluder<E>(scene.geometry, shadow, time, observer) : SurfaceIntersection<E>();
    const Optional<Interaction>& it = hit.it;
    if constexpr (E.media) {
      transmittance *= media.transmittance_along(scene, shadow, hit, light, time, observer);
      if (!it && !scene.volumes.nesting.dielectrics.empty() && !light.infinite && !light.delta)
        if (media.hides(scene.geometry, scene.geometry.emitters[light.light].shape)) return {};
    }
    if (!it || transmittance.is_black()) return transmittance;
    from = *it;
    above = false;
    if (media.hides(scene.geometry, it->shape)) continue;
    const std::uint32_t material = scene.geometry.material(*it);
    if (crossings-- <= 0 || material == kNone) return {};
    transmittance *= surface_transmittance<E>(scene, material, *it, glass_passes, time);
    if (transmittance.is_black()) return {};
  }
}

}  // namespace equaltime
