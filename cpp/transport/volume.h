// What becomes of a path between surfaces: where a medium scatters it, and how much of a light's radiance reaches a
// vertex through media and through surfaces that let it pass. Which medium a ray is in is said by the surface that it
// left last, if that bounds any; otherwise it is still the one in which it came there, as in Mitsuba. Where shapes have
// priorities, it is that of the highest of those that the ray is in (scene/nesting.h).
#pragma once

#include "transport/shadow.h"

namespace equaltime {

namespace detail {
/// A vertex in a medium, on a ray that would have met a surface, if that is given: kept on this side of it.
[[nodiscard]] inline Interaction vertex_within(const Ray& ray, float distance,
                                               const Optional<Interaction>& surface) noexcept {
  Interaction it{};
  it.anchor = {ray.origin + ray.direction * distance, -ray.direction, 0};
  if (surface) {
    const SurfaceAnchor& s = surface->anchor;
    const float height = dot(s.n, it.anchor.p - s.p);
    if (height < s.offset) it.anchor.p = it.anchor.p + s.n * (s.offset - height);
  }
  it.wo = -ray.direction;
  it.frame = Frame::from_normal(it.wo);
  it.shape = it.primitive = it.instance = kNone;
  it.front = true;
  return it;
}

[[nodiscard]] inline float distance_along(const Ray& ray, const Optional<Interaction>& to) noexcept {
  return to ? std::max(0.0F, dot(to->anchor.p - ray.origin, ray.direction)) : kInfinity;
}
}  // namespace detail

/// The medium that a path is in; of no size, and nothing to do, in kernels that know none.
template <Effects E>
class Surroundings {
 public:
  Surroundings(const Scene&, float) noexcept {}
  [[nodiscard]] const Bsdf* follow(const Scene&, const Ray&, const Sampler&, std::uint32_t, const Spectrum&,
                                   const Optional<Interaction>&) const noexcept {
    return nullptr;
  }
  void leave(const Scene&, const Interaction&, bool) const noexcept {}
  [[nodiscard]] static constexpr bool hides(const Scene&, const Interaction&) noexcept { return false; }
  [[nodiscard]] static const Bsdf& beside(const Scene&, const Interaction&, const Bsdf& bsdf,
                                          std::optional<Bsdf>&) noexcept {
    return bsdf;
  }
};

template <Effects E>
requires(E.media) class Surroundings<E> {
 public:
  /// Of a path that begins at a time, if anything moves.
  Surroundings(const Scene& scene, [[maybe_unused]] float time) noexcept
      : bodies_(scene.nesting.always.bodies), around_(scene.nesting.always.medium) {
    if constexpr (E.motion)
      if (!scene.nesting.sometimes.empty()) {
        const Beginning now = scene.beginning(time);
        bodies_ = now.bodies, around_ = now.medium;
      }
  }

  /// Follows a ray towards the surface that it meets, if any. Its throughput becomes what is left of it. If the medium
  /// scatters it before, `it` becomes the vertex where, and its phase function is returned, null otherwise.
  [[nodiscard]] const Bsdf* follow(const Scene& scene, const Ray& ray, const Sampler& sampler, std::uint32_t bounce,
                                   Spectrum& beta, Optional<Interaction>& it) const noexcept {
    const std::uint32_t here = medium_at(scene);
    if (here == kNone || beta.is_black()) return nullptr;
    const Medium& medium = scene.media[here];
    const Point2d u = sampler.get_2d_precise(slot(BounceDimension::medium, bounce));
    const Flight flight = medium.sample(beta, detail::distance_along(ray, it), u);
    beta *= flight.weight;
    if (!flight.collides) return nullptr;
    it = detail::vertex_within(ray, flight.distance, it);
    return &medium.phase;
  }
  /// The path goes on to a side of a vertex.
  void leave(const Scene& scene, const Interaction& it, bool above) noexcept {
    if (it.shape == kNone) return;
    const Surface& surface = scene.surfaces[it.shape];
    const bool before = above == it.front;
    if (surface.rank != kNoRank) {
      bodies_ = before ? others(surface) : bodies_ | only(surface.rank);
      if (!before || bodies_ != 0) return;
    }
    if (surface.bounds_media) around_ = surface.media[before ? 0 : 1];
  }
  /// Whether another body is where a surface is, so that it is not there.
  [[nodiscard]] bool hides(const Scene& scene, const Interaction& it) const noexcept {
    return hides(scene.surfaces[it.shape]);
  }
  [[nodiscard]] bool hides(const Surface& surface) const noexcept {
    return surface.rank != kNoRank && others(surface) != 0 && highest(others(surface)) > surface.rank;
  }
  /// The BSDF of a body's surface with what is beyond it: in `own`, if that is another body.
  [[nodiscard]] const Bsdf& beside(const Scene& scene, const Interaction& it, const Bsdf& bsdf,
                                   std::optional<Bsdf>& own) const noexcept {
    const Surface& surface = scene.surfaces[it.shape];
    if (surface.rank == kNoRank || others(surface) == 0) return bsdf;
    const Bsdf changed = equaltime::within(bsdf, scene.nesting.bodies[index(others(surface))].ior);
    return own.emplace(changed);
  }
  /// What is left of light that comes to the place, over a distance.
  [[nodiscard]] Spectrum transmittance(const Scene& scene, float distance) const noexcept {
    const std::uint32_t here = medium_at(scene);
    return here == kNone ? Spectrum(1) : scene.media[here].transmittance(distance);
  }

 private:
  [[nodiscard]] static std::size_t index(Bodies bodies) noexcept { return static_cast<std::size_t>(highest(bodies)); }
  [[nodiscard]] Bodies others(const Surface& surface) const noexcept { return bodies_ & ~only(surface.rank); }
  [[nodiscard]] std::uint32_t medium_at(const Scene& scene) const noexcept {
    return bodies_ == 0 ? around_ : scene.nesting.bodies[index(bodies_)].medium;
  }

  Bodies bodies_;         // that the path is in
  std::uint32_t around_;  // the medium where no body is; kNone: vacuum
};

/// The part of a light's radiance that gets through to the vertex, by colour, with at most so many surfaces crossed;
/// `above` tells on which side of the vertex the light is.
template <Effects E, class Probe>
[[nodiscard]] Spectrum transmitted(const Scene& scene, const Interaction& vertex, bool above, Surroundings<E> within,
                                   const LightSample& light, int crossings, Probe& probe) noexcept {
  const bool glass_passes = shines_through_glass(scene, light);
  Spectrum share(1);
  Interaction from = vertex;
  for (;;) {
    within.leave(scene, from, above);
    const Ray shadow = shadow_ray(from, above, light);
    const auto it = probe.template blocker<E>(scene, shadow);
    if constexpr (E.media) {
      const bool endless = !it && light.infinite;
      share *= within.transmittance(scene,
                                    endless ? kInfinity : length((it ? it->anchor.p : light.target.p) - shadow.origin));
      if (!it && !scene.nesting.bodies.empty() && !light.infinite && !light.delta)
        if (within.hides(scene.surfaces[scene.emitters[light.light].shape])) return {};
    }
    if (!it || share.is_black()) return share;
    from = *it;
    above = false;
    if (within.hides(scene, *it)) continue;
    const std::uint32_t material = scene.material(*it);
    if (crossings-- <= 0 || material == kNone) return {};
    share *= passing<E>(scene, material, *it, glass_passes, probe.time);
    if (share.is_black()) return {};
  }
}

}  // namespace equaltime
