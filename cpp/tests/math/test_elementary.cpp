// Elementary functions against long double libm: errors are within what each states, over all it is for.
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "equaltime/math/elementary.h"
#include "tests/check.h"

namespace {

using namespace equaltime;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr int kTrials = 400'000;

/// |found - exact| in ulps of the exact value.
double ulps(double found, long double exact) {
  const double rounded = std::abs(static_cast<double>(exact));
  const double ulp = std::nextafter(rounded, kInf) - rounded;
  return static_cast<double>(std::abs(static_cast<long double>(found) - exact) / static_cast<long double>(ulp));
}

/// The largest error of f over a range: evenly, or by even logarithms of the magnitude.
template <class F, class Exact>
double worst(double from, double to, bool by_magnitude, F&& f, Exact&& exact) {
  std::mt19937_64 bits(7);
  std::uniform_real_distribution<double> uniform(by_magnitude ? std::log(from) : from,
                                                 by_magnitude ? std::log(to) : to);
  double most = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double u = uniform(bits), x = by_magnitude ? std::exp(u) : u;
    most = std::max(most, ulps(f(x), exact(static_cast<long double>(x))));
  }
  return most;
}

void hold(const char* what, double found, double stated) {
  std::printf("  %-20s %.3g of %.3g\n", what, found, stated);
  CHECK(found <= stated && found > 0);
}

/// The same function with its argument wrong by two units of the last place: what a test must see.
template <class F>
auto wrong(F f) {
  return [f](double x) { return f(x * (1 + 0x1p-51)); };
}

#define FUNCTION(name) [](double x) { return elementary::name(x); }
#define EXACT(name) [](long double x) { return std::name(x); }

TEST("sine and cosine: 1 ulp near 0, and 2^-52 up to 2^20") {
  hold("sin near 0", worst(1e-300, 0.785, true, FUNCTION(sin), EXACT(sin)), 1);
  CHECK(worst(1e-300, 0.785, true, wrong(FUNCTION(sin)), EXACT(sin)) > 1);
  std::mt19937_64 bits(3);
  double most = 0;
  for (const double reach : {1.0, 10.0, 1e3, 0x1p20}) {
    std::uniform_real_distribution<double> uniform(-reach, reach);
    for (int i = 0; i < kTrials; ++i) {
      const double x = uniform(bits);
      const auto [s, c] = elementary::sin_cos(x);
      const auto exact = static_cast<long double>(x);
      most = std::max({most, static_cast<double>(std::abs(static_cast<long double>(s) - std::sin(exact))),
                       static_cast<double>(std::abs(static_cast<long double>(c) - std::cos(exact)))});
    }
  }
  hold("sin and cos, / 2^-52", most * 0x1p52, 1);
  CHECK(std::isnan(elementary::sin(0x1.1p20)) && std::isnan(elementary::cos(kInf)));
  static_assert(elementary::sin(0.0) == 0 && elementary::cos(0.0) == 1);
}

TEST("exp: 1 ulp, from underflow to overflow") {
  hold("exp", worst(-708, 709.7, false, FUNCTION(exp), EXACT(exp)), 1);
  hold("exp near 0", worst(1e-20, 1, true, FUNCTION(exp), EXACT(exp)), 1);
  CHECK(worst(-708, 709.7, false, wrong(FUNCTION(exp)), EXACT(exp)) > 1);
  CHECK(elementary::exp(-746.0) == 0 && elementary::exp(710.0) == kInf && elementary::exp(0.0) == 1);
  CHECK(elementary::exp(-745.0) > 0 && elementary::exp(-kInf) == 0 && std::isnan(elementary::exp(std::nan(""))));
}

TEST("logarithms: 2 and 3 ulp, subnormal numbers too") {
  hold("log", worst(1e-320, 1e300, true, FUNCTION(log), EXACT(log)), 2);
  hold("log near 1", worst(0.5, 2, false, FUNCTION(log), EXACT(log)), 2);
  hold("log1p", worst(1e-300, 1e10, true, FUNCTION(log1p), EXACT(log1p)), 3);
  hold("log1p below 0", worst(-0.999999, -1e-12, false, FUNCTION(log1p), EXACT(log1p)), 3);
  CHECK(worst(0.9, 1.1, false, wrong(FUNCTION(log)), EXACT(log)) > 2);
  CHECK(elementary::log(1.0) == 0 && elementary::log(0.0) == -kInf && elementary::log(kInf) == kInf);
  CHECK(std::isnan(elementary::log(-1.0)) && elementary::log1p(-1.0) == -kInf);
}

TEST("powers: an error that grows with the exponent") {
  std::mt19937_64 bits(5);
  std::uniform_real_distribution<double> base(0, 2), exponent(-20, 20);
  double most = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double x = base(bits), y = exponent(bits);
    const long double exact = std::pow(static_cast<long double>(x), static_cast<long double>(y));
    const auto error = static_cast<double>(std::abs(static_cast<long double>(elementary::pow(x, y)) / exact - 1));
    most = std::max(most, error / (0x1p-52 * (1 + 2 * std::abs(y * std::log(x)))));
  }
  hold("pow, / its bound", most, 1);
  CHECK(elementary::pow(0.0, 2.4) == 0 && elementary::pow(0.0, 0.0) == 1 && elementary::pow(3.0, 0.0) == 1);
}

TEST("angles: 2 ulp in every direction, with the signs of zeros and infinities") {
  std::mt19937_64 bits(11);
  std::uniform_real_distribution<double> turn(-3.15, 3.15), scale(-300, 300);
  double most = 0, seen = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double angle = turn(bits), r = std::exp(scale(bits)), x = r * std::cos(angle), y = r * std::sin(angle);
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    most = std::max(most, ulps(elementary::atan2(y, x), exact));
    seen = std::max(seen, ulps(elementary::atan2(y * (1 + 0x1p-50), x), exact));
  }
  hold("atan2", most, 2);
  CHECK(seen > 2);
  for (const double y : {0.0, -0.0, 1.0, -1.0, kInf, -kInf, 1e-310})
    for (const double x : {0.0, -0.0, 1.0, -1.0, kInf, -kInf}) {
      const double found = elementary::atan2(y, x), exact = std::atan2(y, x);
      CHECK(std::abs(found - exact) <= 0x1p-51 && std::signbit(found) == std::signbit(exact));
    }
  CHECK(std::isnan(elementary::atan2(std::nan(""), 1)) && std::isnan(elementary::atan2(1, std::nan(""))));
  hold("acos", worst(-1, 1, false, FUNCTION(acos), EXACT(acos)), 4);
  CHECK(elementary::acos(1) == 0 && std::isnan(elementary::acos(1.0000001)));
}

TEST("roots and lengths") {
  hold("cbrt", worst(1e-300, 1e300, true, FUNCTION(cbrt), EXACT(cbrt)), 1);
  CHECK(elementary::cbrt(-8.0) == -2 && elementary::cbrt(0.0) == 0);
  std::mt19937_64 bits(13);
  std::uniform_real_distribution<double> scale(-700, 700), part(-1, 1);
  double most = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double r = std::exp(scale(bits)), x = r * part(bits), y = r * part(bits), z = r * part(bits);
    const auto a = static_cast<long double>(x), b = static_cast<long double>(y), c = static_cast<long double>(z);
    most = std::max(most, ulps(elementary::hypot(x, y, z), std::sqrt(a * a + b * b + c * c)));
  }
  hold("hypot", most, 3);
  CHECK(elementary::hypot(0.0, 0.0) == 0 && elementary::hypot(-3.0, 4.0) == 5);
}

/// |found - exact| in ulps of float32.
double float_ulps(float found, double exact) {
  const float rounded = std::abs(static_cast<float>(exact)), next = std::nextafter(rounded, kInfinity);
  return std::abs(static_cast<double>(found) - exact) / static_cast<double>(next - rounded);
}

template <class F, class Exact>
double worst_float(float from, float to, F&& f, Exact&& exact) {
  std::mt19937_64 bits(17);
  std::uniform_real_distribution<float> uniform(from, to);
  double most = 0;
  for (int i = 0; i < kTrials; ++i) {
    const float x = uniform(bits);
    most = std::max(most, float_ulps(f(x), exact(static_cast<double>(x))));
  }
  return most;
}

#define FLOAT_FUNCTION(name) [](float x) { return elementary::name(x); }
#define FLOAT_EXACT(name) [](double x) { return std::name(x); }

TEST("functions of float32 numbers: 1 ulp") {
  hold("exp", worst_float(-87.0F, 88.7F, FLOAT_FUNCTION(exp), FLOAT_EXACT(exp)), 1);
  hold("log", worst_float(0.0F, 3.0F, FLOAT_FUNCTION(log), FLOAT_EXACT(log)), 1);
  hold("log, large", worst_float(0.0F, 3e38F, FLOAT_FUNCTION(log), FLOAT_EXACT(log)), 1);
  hold("erf", worst_float(-5.0F, 5.0F, FLOAT_FUNCTION(erf), FLOAT_EXACT(erf)), 1);
  const auto off = [](float x) { return elementary::exp(x) * (1 + 0x1p-22F); };
  CHECK(worst_float(-87.0F, 88.7F, off, FLOAT_EXACT(exp)) > 1);
  CHECK(elementary::exp(89.0F) == kInfinity && elementary::exp(-105.0F) == 0 && elementary::exp(-100.0F) > 0);
  CHECK(elementary::log(0.0F) == -kInfinity && std::isnan(elementary::log(-1.0F)) && elementary::erf(9.0F) == 1);
  const float nan = std::nanf("");
  CHECK(std::isnan(elementary::exp(nan)) && std::isnan(elementary::erf(nan)) && std::isnan(elementary::log(nan)));
}

}  // namespace

int main() { return check::run(); }
