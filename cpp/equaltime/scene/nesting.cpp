#include "equaltime/scene/nesting.h"

#include "equaltime/scene/instance.h"
#include "equaltime/shapes/winding.h"

namespace equaltime {

Bsdf with_exterior_ior(const Bsdf& bsdf, float outside) noexcept {
  const auto over = [outside](float ior) noexcept {
    return static_cast<float>(static_cast<double>(ior) / static_cast<double>(outside));
  };
  if (const auto* smooth = std::get_if<Dielectric<float>>(&bsdf)) {
    Dielectric<float> d = *smooth;
    d.ior = over(d.ior);
    return d;
  }
  const auto* rough = std::get_if<RoughDielectric<float>>(&bsdf);
  if (rough == nullptr) return bsdf;
  RoughDielectric<float> d = *rough;
  d.ior = over(d.ior);
  if (d.ior != 1) return d;
  Dielectric<float> clear{DielectricDescription{}};  // facets between equal indices turn nothing
  clear.ior = 1;
  clear.specular_transmittance = d.specular_transmittance;
  return clear;
}

void ClosedShape::include_if_inside(CameraMedium& state, const Surface& surface, const Vec3d& camera,
                                    const Instance* in, float time) const noexcept {
  const bool ranked = surface.media.rank != kNoRank;
  const Vec3d place = in != nullptr ? in->to_local({camera, {0, 0, 1}, 1}).origin : camera;
  const auto found = index             ? index->enclosure(place, time)
                     : mesh != nullptr ? enclosure(*mesh, place, time)
                                       : std::optional(enclosure(*sphere, surface.flipped, place));
  const bool turned = mesh != nullptr && surface.flipped;
  if (!found || found->behind == turned) return;
  if (ranked) {
    state.dielectrics |= dielectric_bit(surface.media.rank);
    return;
  }
  // Each group's space has a unit of its own, so volumes are compared in the scene's space. They are finite there: its
  // unit suits everything that is placed in it.
  const double volume = in != nullptr ? found->volume * in->magnification() : found->volume;
  if (!(volume < state.smallest)) return;
  state.smallest = volume;
  state.medium = surface.media.sides[1];
}

/// Instances of a shape share its index. Each counts an equal part of it.
std::size_t Nesting::memory_bytes() const noexcept {
  std::size_t bytes =
      dielectrics.capacity() * sizeof(NestedDielectric) + time_dependent.capacity() * sizeof(ClosedShape);
  for (const ClosedShape& closed : time_dependent)
    if (closed.index) bytes += closed.index->memory_bytes() / static_cast<std::size_t>(closed.index.use_count());
  return bytes;
}

}  // namespace equaltime
