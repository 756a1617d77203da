// Samplers over lanes: each lane has the numbers of one path.
#include "equaltime/sampling/sampler.h"
#include "tests/check.h"
#include "tests/lanes.h"

namespace {

using namespace equaltime;

using Wide = BasicSampler<Floats>;
constexpr BounceDecision kDecisions[] = {BounceDecision::light_pick, BounceDecision::bsdf_direction,
                                         BounceDecision::technique};

/// Whether lane i of all that samplers give has the numbers of one path with the pixel, sample and bounce of lane j.
bool agrees(SamplerKind kind, const Pack<std::uint64_t>& pixel, const Pack<std::uint64_t>& index,
            const Pack<std::uint32_t>& bounce, std::size_t i, std::size_t j) {
  const Wide wide = Wide::at(kind, 7, pixel, index, 3);
  const Sampler one = Sampler::at(kind, 7, pixel[j], index[j], 3);
  bool same = true;
  for (const BounceDecision d : kDecisions) {
    const BasicSlot<Floats> slots = slot<Floats>(d, bounce);
    const Slot s = slot(d, bounce[j]);
    const Point2<Floats> points = wide.get_2d(slots);
    const Point2<Pack<double>> precise = wide.get_2d_precise(slots);
    const Point2f point = one.get_2d(s);
    const Point2d precise_point = one.get_2d_precise(s);
    same = same && wide.bits(slots)[i] == one.bits(s) && wide.get_1d(slots)[i] == one.get_1d(s) &&
           wide.get_1d_precise(slots)[i] == one.get_1d_precise(s) && points.x[i] == point.x && points.y[i] == point.y &&
           precise.x[i] == precise_point.x && precise.y[i] == precise_point.y;
  }
  const auto numbers = wide.vertex(bounce);
  const VertexNumbers alone = one.vertex(bounce[j]);
  return same && numbers.light_point.x[i] == alone.light_point.x &&
         numbers.bsdf_direction.y[i] == alone.bsdf_direction.y;
}

TEST("lanes of every sampler have the numbers of one path") {
  for (const SamplerKind kind :
       {SamplerKind::independent, SamplerKind::stratified, SamplerKind::sobol, SamplerKind::lattice}) {
    int mixed_up = 0;  // the twin: numbers of the next lane differ
    for (std::uint32_t k = 0; k < 200; ++k) {
      Pack<std::uint64_t> pixel, index;
      Pack<std::uint32_t> bounce;  // also beyond those that the lattice has
      for (std::uint32_t i = 0; i < kLanes; ++i) pixel[i] = 31 * k + i, index[i] = 17 * k + 5 * i, bounce[i] = 3 * i;
      for (std::size_t i = 0; i < kLanes; ++i) {
        CHECK(agrees(kind, pixel, index, bounce, i, i));
        mixed_up += !agrees(kind, pixel, index, bounce, i, (i + 1) % kLanes);
      }
    }
    CHECK(mixed_up == 200 * static_cast<int>(kLanes));
  }
}

}  // namespace

int main() { return check::run(); }
