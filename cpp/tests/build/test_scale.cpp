// No absolute epsilon anywhere: a scene in other units, or with brighter lights, gives the same image, bit by bit.
#include "tests/check.h"
#include "tests/scenes.h"

namespace {

using namespace scenes;

constexpr std::uint64_t kSamples = 8;

SceneDescription clipped(SceneDescription d) {
  view_of(d).near = 3.5, view_of(d).far = 5;
  return d;
}

// Brought back from lights s times as bright, for s a power of two.
Moments rescaled(Moments moments, double s) {
  for (PixelMoments& m : moments)
    for (int c = 0; c < 3; ++c) m.mean[c] /= s, m.deviation[c] = upper_half(from_upper_half(m.deviation[c]) / s);
  return moments;
}

const Settings kByTree{.light_selection = LightSelection::tree};

TEST("lengths times a power of two change no bit, with point light intensities scaled by its square") {
  for (const SceneDescription& d :
       {room(), full_room(), clipped(full_room()), through_a_lens(clipped(room())), from_afar(full_room()),
        in_motion(full_room()), in_motion(through_a_lens(room())), in_motion(from_afar(full_room()))})
    for (const Settings& settings : {Settings{}, kByTree}) {
      const Moments reference = rendered(built(d), kSamples, settings);
      CHECK(mean(reference) > 0.01);
      for (const double s : {0x1p-20, 0x1p-7, 2.0, 0x1p20})
        CHECK(same_bits(rendered(built(with_lengths(d, s)), kSamples, settings), reference));
    }
}

TEST("light times a power of two scales the image exactly") {
  for (const SceneDescription& d : {room(), full_room(), in_motion(room())})
    for (const Settings& settings : {Settings{}, kByTree}) {
      const Moments reference = rendered(built(d), kSamples, settings);
      for (const double s : {0x1p-40, 0x1p-1, 0x1p40})
        CHECK(same_bits(rescaled(rendered(built(with_light(d, s)), kSamples, settings), s), reference));
    }
}

TEST("both at once, at their extremes, change no bit either") {
  const Moments reference = rendered(built(full_room()), kSamples);
  for (const double s : {0x1p-20, 0x1p20})
    for (const double l : {0x1p-40, 0x1p40})
      CHECK(same_bits(rescaled(rendered(built(with_light(with_lengths(full_room(), s), l)), kSamples), l), reference));
}

TEST("the test sees a scale that is no power of two, and a light left in its old units") {
  const Moments reference = rendered(built(full_room()), kSamples);
  CHECK(!same_bits(rendered(built(with_lengths(full_room(), 3)), kSamples), reference));
  SceneDescription d = with_lengths(full_room(), 2);
  d.point_lights[0].intensity = full_room().point_lights[0].intensity;
  CHECK(!same_bits(rendered(built(d), kSamples), reference));
}

}  // namespace

int main() { return check::run(); }
