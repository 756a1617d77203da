// MIS weights over the whole range of float32 densities.
#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <random>

#include "equaltime/sampling/mis.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

// What a weight must not be: the squares leave float32's range long before the densities do.
float weight_by_squares(float pdf, float other) { return pdf * pdf / (pdf * pdf + other * other); }

template <class Weight>
int broken_pairs(Weight weight) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-38, 38);
  int broken = 0;
  for (int i = 0; i < 200000; ++i) {
    const auto a = static_cast<float>(std::pow(10, exponent(random)));
    const auto b = static_cast<float>(std::pow(10, exponent(random)));
    const float wa = weight(a, b), wb = weight(b, a);
    const bool good =
        wa >= 0 && wa <= 1 && wb >= 0 && wb <= 1 && std::abs(wa + wb - 1) <= 0x1p-22F && (wa >= wb) == (a >= b);
    broken += good ? 0 : 1;
  }
  return broken;
}

TEST("the weights of two techniques sum to 1, whatever their densities") {
  for (const Heuristic h : {Heuristic::balance, Heuristic::power})
    CHECK(broken_pairs([h](float a, float b) { return mis_weight(h, a, b); }) == 0);
}

TEST("the same test rejects weights formed from squares") { CHECK(broken_pairs(weight_by_squares) > 0); }

#ifdef __SSE__
// What Embree recommends for speed: denormal numbers are 0, as arguments and as results.
struct Flushing {
  unsigned before = _mm_getcsr();
  Flushing() { _mm_setcsr(before | 0x8040U); }
  ~Flushing() { _mm_setcsr(before); }
  Flushing(const Flushing&) = delete;
  Flushing& operator=(const Flushing&) = delete;
};

TEST("so they do where denormal numbers are flushed to 0, and weights formed from squares are rejected there (S2)") {
  const Flushing flushing;
  volatile float least = 0x1p-126F;
  CHECK(least * 0.5F == 0);
  // Densities that are denormal themselves are no densities here.
  const auto normal = [](auto weight) {
    return [weight](float a, float b) { return weight(std::max(a, 0x1p-126F), std::max(b, 0x1p-126F)); };
  };
  for (const Heuristic h : {Heuristic::balance, Heuristic::power})
    CHECK(broken_pairs(normal([h](float a, float b) { return mis_weight(h, a, b); })) == 0);
  CHECK(broken_pairs(normal(weight_by_squares)) > 0);
}
#endif

TEST("a technique that alone can make a sample has weight 1, and equal ones share it") {
  for (const Heuristic h : {Heuristic::balance, Heuristic::power})
    for (const float pdf : {1e-38F, 1.0F, 1e38F}) {
      CHECK(mis_weight(h, pdf, 0) == 1);
      CHECK(mis_weight(h, pdf, pdf) == 0.5F);
    }
}

TEST("the heuristics are those of Veach") {
  CHECK(std::abs(mis_weight(Heuristic::balance, 3, 1) - 0.75F) < 1e-6F);
  CHECK(std::abs(mis_weight(Heuristic::power, 3, 1) - 0.9F) < 1e-6F);
}

}  // namespace

int main() { return check::run(); }
