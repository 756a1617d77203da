// What becomes of a path between surfaces: where a medium scatters it, and how much of a light's radiance reaches a
// vertex through media and through surfaces that let it pass. Which medium a ray is in is said by the surface that it
// left last, if that bounds any; otherwise it is still the one in which it came there, as in Mitsuba. Where shapes have
// priorities, it is that of the highest of those that the ray is in (scene/nesting.h). Distances are those of float64,
// from where the path is and not from where Embree's ray begins: in a dense medium the difference is many mean free
// paths.
#pragma once

#include <limits>

#include "equaltime/base/effects.h"
#include "equaltime/base/floating_point.h"
#include "equaltime/scene/scene.h"
#include "equaltime/transport/nearby.h"
#include "equaltime/transport/shadow.h"

namespace equaltime {

namespace detail {
/// A vertex in a medium, on a ray; the next begins at `p`.
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

/// The medium that a path is in. Kernels without media have this empty one.
template <Effects E>
class MediumStack {
 public:
  void leave(const SceneGeometry&, const Interaction&, bool) const noexcept {}
  [[nodiscard]] static constexpr bool hides(const SceneGeometry&, const Interaction&) noexcept { return false; }
  [[nodiscard]] static const Bsdf& with_exterior(const Scene&, const Interaction&, const Bsdf& bsdf,
                                                 std::optional<Bsdf>&) noexcept {
    return bsdf;
  }
};

template <Effects E>
requires(E.media) class MediumStack<E> {
 public:
  /// Of a path that begins with a ray, at a time if anything moves.
  MediumStack(const Scene& scene, const Ray& camera_ray, [[maybe_unused]] float time) noexcept
      : bodies_(scene.volumes.nesting.always.bodies),
        around_(scene.volumes.nesting.always.medium),
        place_(camera_ray.origin) {
    if constexpr (E.motion)
      if (!scene.volumes.nesting.sometimes.empty()) {
        const CameraMedium now = scene.camera_medium(time);
        bodies_ = now.bodies, around_ = now.medium;
      }
  }

  /// The path goes on to a side of a vertex.
  void leave(const SceneGeometry& geometry, const Interaction& it, bool above) noexcept {
    if (it.shape == kNone) return;
    const Surface& surface = geometry.surfaces[it.shape];
    const bool before = above == it.front;
    if (surface.rank != kNoRank) {
      bodies_ = before ? others(surface) : bodies_ | only(surface.rank);
      if (!before || bodies_ != 0) return;
    }
    if (surface.bounds_media) around_ = surface.media[before ? 0 : 1];
  }
  /// Whether a dielectric of higher priority holds the point, and hides the surface.
  [[nodiscard]] bool hides(const SceneGeometry& geometry, const Interaction& it) const noexcept {
    return hides(geometry.surfaces[it.shape]);
  }
  [[nodiscard]] bool hides(const Surface& surface) const noexcept {
    return surface.rank != kNoRank && others(surface) != 0 && highest(others(surface)) > surface.rank;
  }
  /// The BSDF of a body's surface with what is beyond it: in `own`, if that is another body.
  [[nodiscard]] const Bsdf& with_exterior(const Scene& scene, const Interaction& it, const Bsdf& bsdf,
                                          std::optional<Bsdf>& own) const noexcept {
    const Surface& surface = scene.geometry.surfaces[it.shape];
    if (surface.rank == kNoRank || others(surface) == 0) return bsdf;
    const Bsdf changed = with_exterior_ior(bsdf, scene.volumes.nesting.bodies[index(others(surface))].ior);
    return own.emplace(changed);
  }
  /// Follows a shadow ray to the surface that it meets, or else to the light: what is left of its light.
  [[nodiscard]] Spectrum transmittance_along(const Scene& scene, const Ray& shadow, const ExactIntersection& hit,
                                             const LightSample& light, float time) noexcept {
    const std::uint32_t here = medium_index(scene.volumes);
    const Vec3d from = place_;
    if (hit.it) place_ = hit.point;
    if (here == kNone) return Spectrum(1);
    const Medium& medium = scene.volumes.media[here];
    if (hit.it)
      return medium.transmittance(distance_along(from, shadow.direction, hit) * length(Vec3d(shadow.direction)));
    if (light.infinite) return medium.transmittance(std::numeric_limits<double>::infinity());
    return medium.transmittance(distance_to(scene.geometry, medium, from, shadow, light, time));
  }

  /// The medium that the path is in; kNone: vacuum.
  [[nodiscard]] std::uint32_t medium_index(const Volumes& volumes) const noexcept {
    return bodies_ == 0 ? around_ : volumes.nesting.bodies[index(bodies_)].medium;
  }
  [[nodiscard]] const Vec3d& place() const noexcept { return place_; }
  void move_to(const Vec3d& place) noexcept { place_ = place; }

 private:
  /// How much of a mean free path the place of a lamp may be off.
  static constexpr float kFarOff = 1e-4F;

  /// The distance of a light sample that nothing occludes. In dense media its rounded point is not good enough, and a
  /// ray finds the exact one.
  [[nodiscard, gnu::noinline]] static double distance_to(const SceneGeometry& geometry, const Medium& medium,
                                                         const Vec3d& from, const Ray& shadow, const LightSample& light,
                                                         [[maybe_unused]] float time) noexcept {
    if (!light.delta && medium.sigma_t.max_component() * light.target.offset > kFarOff) {
      const ExactIntersection lamp = geometry.closest<E, ScopedFpEnvironment>({shadow.origin, light.wi}, time);
      if (lamp.it && geometry.emits(*lamp.it) && geometry.light_of(*lamp.it) == light.light)
        return distance_along(from, light.wi, lamp);
    }
    return length(Vec3d(light.target.p) - from);
  }
  [[nodiscard]] static std::size_t index(DielectricSet bodies) noexcept {
    return static_cast<std::size_t>(highest(bodies));
  }
  [[nodiscard]] DielectricSet others(const Surface& surface) const noexcept { return bodies_ & ~only(surface.rank); }

  DielectricSet bodies_;  // that the path is in
  std::uint32_t around_;  // the medium where no body is; kNone: vacuum
  Vec3d place_;           // of the path: its last vertex, or the camera
};

/// The surroundings of a path that media scatter, and the surfaces that it is close to.
template <Effects E>
class PathMediumStack {
 public:
  PathMediumStack(const Scene&, const Ray&, float) noexcept {}
  [[nodiscard]] static MediumStack<E> here() noexcept { return {}; }
  [[nodiscard]] const PhaseFunction* sample_distance(const Scene&, const Ray&, const Sampler&, std::uint32_t,
                                                     const Spectrum&, const Optional<Interaction>&) const noexcept {
    return nullptr;
  }
  void leave(const Scene&, const Interaction&, bool) const noexcept {}
};

template <Effects E>
requires(E.media) class PathMediumStack<E> {
 public:
  /// Of a path that begins with a ray, at a time if anything moves.
  PathMediumStack(const Scene& scene, const Ray& camera_ray, float time) noexcept : here_(scene, camera_ray, time) {}

  [[nodiscard]] const MediumStack<E>& here() const noexcept { return here_; }

  /// Samples a distance along the ray, and updates the throughput `beta`. If the medium scatters, `ahead` becomes the
  /// vertex there, and its phase function is returned; null otherwise.
  [[nodiscard]] EQUALTIME_INLINE const PhaseFunction* sample_distance(const Scene& scene, const Ray& ray,
                                                                      const Sampler& sampler, std::uint32_t bounce,
                                                                      Spectrum& beta,
                                                                      ExactIntersection& ahead) noexcept {
    const std::uint32_t medium_here = here_.medium_index(scene.volumes);
    const Vec3d from = here_.place();
    Optional<Interaction>& it = ahead.it;
    if (it) here_.move_to(ahead.point);
    if (medium_here == kNone || beta.is_black()) return nullptr;
    const Medium& medium = scene.volumes.media[medium_here];
    const Point2d u = sampler.get_2d_precise(slot(BounceDimension::medium, bounce));
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
  /// The path goes on to a side of a vertex.
  void leave(const Scene& scene, const Interaction& it, bool above) noexcept {
    if (it.shape == kNone) return;
    here_.leave(scene.geometry, it, above);
    if (here_.medium_index(scene.volumes) == kNone)
      nearby_.clear();
    else
      nearby_.leave(here_.place(), above ? it.anchor.n : -it.anchor.n, it.anchor.offset);
  }

 private:
  MediumStack<E> here_;
  NearbySurfaces nearby_;
};

/// The part of a light's radiance that gets through to the vertex, by colour, with at most so many surfaces crossed;
/// `above` tells on which side of the vertex the light is.
template <Effects E, Observer O>
[[nodiscard]] Spectrum shadow_transmittance(const Scene& scene, const Interaction& vertex, bool above,
                                            MediumStack<E> media, const LightSample& light, int crossings, float time,
                                            O& observer) noexcept(!O::allocates) {
  const bool glass_passes = shines_through_glass(scene, light);
  // within media it also counts how far surfaces are, to more digits than Embree tells
  const bool may_pass = scene.appearance.lets_light_pass || (E.media && !scene.volumes.media.empty());
  Spectrum share(1);
  Interaction from = vertex;
  for (;;) {
    media.leave(scene.geometry, from, above);
    const Ray shadow = shadow_ray(from, above, light);
    if (!may_pass && occluded<E>(scene.geometry, shadow, time, observer)) return {};
    auto hit = may_pass ? closest_occluder<E>(scene.geometry, shadow, time, observer) : SurfaceIntersection<E>();
    const Optional<Interaction>& it = interaction(hit);
    if constexpr (E.media) {
      share *= media.transmittance_along(scene, shadow, hit, light, time);
      if (!it && !scene.volumes.nesting.bodies.empty() && !light.infinite && !light.delta)
        if (media.hides(scene.geometry.surfaces[scene.geometry.emitters[light.light].shape])) return {};
    }
    if (!it || share.is_black()) return share;
    from = *it;
    above = false;
    if (media.hides(scene.geometry, *it)) continue;
    const std::uint32_t material = scene.geometry.material(*it);
    if (crossings-- <= 0 || material == kNone) return {};
    share *= surface_transmittance<E>(scene, material, *it, glass_passes, time);
    if (share.is_black()) return {};
  }
}

}  // namespace equaltime
