// Models over lanes: each lane has the bits that one path has.
#include <random>
#include <type_traits>

#include "equaltime/bsdfs/bsdf.h"
#include "tests/check.h"
#include "tests/lanes.h"

namespace {

using namespace equaltime;

/// Two directions, numbers and a side, for each lane.
struct Case {
  Vec3<Floats> wo, wi;
  Truths front;
  Pack<double> u_lobe;
  Point2<Floats> u;

  explicit Case(std::mt19937& random) {
    std::uniform_real_distribution<float> unit(0, 1);
    for (std::size_t i = 0; i < kLanes; ++i) {
      set_lane(wo, i, square_to_uniform_hemisphere(Point2f{unit(random) * 0.999F, unit(random)}));
      set_lane(wi, i, square_to_uniform_sphere(Point2f{unit(random), unit(random)}));
      front[i] = unit(random) < 0.5F;
      u_lobe[i] = static_cast<double>(unit(random));
      u.x[i] = unit(random), u.y[i] = unit(random);
    }
  }
};

/// Whether lane i of a pack has the same bits as one path with the numbers of lane j.
template <class Wide, class One>
bool agrees(const Wide& wide, const One& one, const Case& c, std::size_t i, std::size_t j) {
  const Vec3f wo = lane(c.wo, j), wi = lane(c.wi, j);
  const auto values = wide.eval(c.wo, c.wi, c.front);
  const BsdfValue<float> value = one.eval(wo, wi, c.front[j]);
  if (!same(lane(values.f, i), value.f) || !same(values.pdf[i], value.pdf)) return false;
  if (!same(lane(wide.albedo(c.wo, c.front), i), one.albedo(wo, c.front[j]))) return false;
  const auto samples = wide.sample(c.wo, c.front, c.u_lobe, c.u);
  const auto sample = one.sample(wo, c.front[j], c.u_lobe[j], lane(c.u, j));
  if (samples.has_value()[i] != sample.has_value()) return false;
  if (!sample) return true;
  return same(lane(samples->wi, i), sample->wi) && same(lane(samples->weight, i), sample->weight) &&
         same(samples->pdf[i], sample->pdf) && samples->delta[i] == sample->delta &&
         same(samples->eta_scale[i], sample->eta_scale);
}

template <class Model>
auto described(const typename Model::Description& d, BsdfTables& tables) {
  if constexpr (std::is_constructible_v<Model, const typename Model::Description&, BsdfTables&>)
    return Model(d, tables);
  else
    return Model(d);
}

template <class Model>
void check_lanes(const typename Model::Description& d) {
  using Wide = LanesOf<Model>;
  BsdfTables tables;
  const auto wide = described<Wide>(d, tables);
  const auto one = described<Model>(d, tables);
  std::mt19937 random(1);
  int mixed_up = 0;  // the twin: numbers of the next lane do not give the same
  for (int k = 0; k < 500; ++k) {
    const Case c(random);
    for (std::size_t i = 0; i < kLanes; ++i) {
      CHECK(agrees(wide, one, c, i, i));
      mixed_up += !agrees(wide, one, c, i, (i + 1) % kLanes);
    }
  }
  CHECK(mixed_up > 500);
}

TEST("lanes of every model have the bits of one path") {
  int checked = 0;
  Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
    if constexpr (kHasLanes<Model>) {
      typename Model::Description d{};
      if constexpr (requires { d.reflectance; }) d.reflectance = {0.2, 0.5, 0.8};
      if constexpr (requires { d.eta; })
        d.eta = {0.2, 0.9, 1.5}, d.k = {3, 2, 4}, d.specular_reflectance = {1, 0.9, 0.8};
      check_lanes<Model>(d);
      if constexpr (requires { d.distribution; }) {
        d.distribution = MicrofacetModel::beckmann;
        check_lanes<Model>(d);
      }
      ++checked;
    }
  });
  CHECK(checked == static_cast<int>(Bsdfs::size) - 1);  // all but principled
}

}  // namespace

int main() { return check::run(); }
