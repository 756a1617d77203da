// Models over lanes: each lane has the bits that one path has.
#include <random>
#include <type_traits>

#include "equaltime/bsdfs/bsdf.h"
#include "tests/check.h"
#include "tests/lanes.h"

namespace {

using namespace equaltime;

/// Two directions, numbers and a side.
template <class Real>
struct Case {
  Vec3<Real> wo, wi;
  Mask<Real> front;
  Double<Real> u_lobe;
  Point2<Real> u;
};

Case<float> random_case(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0, 1);
  Case<float> c{};
  c.wo = square_to_uniform_hemisphere(Point2f{unit(random) * 0.999F, unit(random)});
  c.wi = square_to_uniform_sphere(Point2f{unit(random), unit(random)});
  c.front = unit(random) < 0.5F;
  c.u_lobe = static_cast<double>(unit(random));
  c.u.x = unit(random), c.u.y = unit(random);
  return c;
}

void set_lane(Case<Floats>& wide, std::size_t i, const Case<float>& one) {
  set_lane(wide.wo, i, one.wo), set_lane(wide.wi, i, one.wi), set_lane(wide.u, i, one.u);
  wide.front[i] = one.front, wide.u_lobe[i] = one.u_lobe;
}

/// All that a model gives for a case.
template <class Real>
struct Answer {
  BsdfValue<Real> value;
  Rgb<Real> albedo;
  BsdfSample<Real> sample;
  Mask<Real> has_value;
};

template <class Model, class Real>
Answer<Real> answer(const Model& model, const Case<Real>& c) {
  const auto sample = model.sample(c.wo, c.front, c.u_lobe, c.u);
  return {model.eval(c.wo, c.wi, c.front), model.albedo(c.wo, c.front), *sample, sample.has_value()};
}

bool same_sample(const BsdfSample<Floats>& samples, std::size_t i, const BsdfSample<float>& sample) {
  return same(lane(samples.wi, i), sample.wi) && same(lane(samples.weight, i), sample.weight) &&
         same(samples.pdf[i], sample.pdf) && samples.delta[i] == sample.delta &&
         same(samples.eta_scale[i], sample.eta_scale);
}

bool agrees(const Answer<Floats>& wide, std::size_t i, const Answer<float>& one) {
  return same(lane(wide.value.f_cos, i), one.value.f_cos) && same(wide.value.pdf[i], one.value.pdf) &&
         same(lane(wide.albedo, i), one.albedo) && wide.has_value[i] == one.has_value &&
         (!one.has_value || same_sample(wide.sample, i, one.sample));
}

template <class Model>
auto described(const typename Model::Description& d, BsdfTables& tables) {
  if constexpr (std::is_constructible_v<Model, const typename Model::Description&, BsdfTables&>)
    return Model(d, tables);
  else
    return Model(d);
}

template <class Model>
void check_model(const typename Model::Description& d) {
  BsdfTables tables;
  const auto wide = described<LanesOf<Model>>(d, tables);
  const auto one = described<Model>(d, tables);
  std::mt19937 random(1);
  const NextLane next = check_lanes<Case>(
      500, [&] { return random_case(random); },
      [&]<class Real>(const Case<Real>& c) {
        if constexpr (std::is_same_v<Real, float>)
          return answer(one, c);
        else
          return answer(wide, c);
      });
  CHECK(next.differs > 500);
}

TEST("lanes of every model have the bits of one path") {
  int checked = 0;
  Bsdfs::for_each([&]<class Model>(std::type_identity<Model>) {
    if constexpr (kHasLanes<Model>) {
      typename Model::Description d{};
      if constexpr (requires { d.reflectance; }) d.reflectance = {0.2, 0.5, 0.8};
      if constexpr (requires { d.eta; })
        d.eta = {0.2, 0.9, 1.5}, d.k = {3, 2, 4}, d.specular_reflectance = {1, 0.9, 0.8};
      check_model<Model>(d);
      if constexpr (requires { d.distribution; }) {
        d.distribution = MicrofacetModel::beckmann;
        check_model<Model>(d);
      }
      if constexpr (requires { d.use_fast_approx; }) {
        d.use_fast_approx = true;
        check_model<Model>(d);
      }
      ++checked;
    }
  });
  CHECK(checked == static_cast<int>(Bsdfs::size) - 1);  // all but principled
}

}  // namespace

int main() { return check::run(); }
