// The ordered table: its stated probabilities, its order, and numbers at the ends of its entries.
#include <cmath>
#include <random>
#include <vector>

#include "equaltime/sampling/piecewise_constant_1d.h"
#include "tests/check.h"

namespace {

using namespace equaltime;

std::vector<double> uneven(std::size_t n) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> exponent(-12, 0);
  std::vector<double> weights(n);
  for (std::size_t i = 0; i < n; ++i) weights[i] = i % 7 == 3 ? 0 : std::pow(10, exponent(random));
  return weights;
}

// What inverting the running sum by walking along it gives.
PiecewiseConstant1D::Choice walked(const PiecewiseConstant1D& table, std::size_t n, double u) {
  double below = 0;
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    const double p = table.pmf(i);
    if (u < below + p) return {i, (u - below) / p};
    below += p;
  }
  return {static_cast<std::uint32_t>(n - 1), (u - below) / table.pmf(static_cast<std::uint32_t>(n - 1))};
}

TEST("probabilities are the weights' shares, and add up to one") {
  for (const std::size_t n : {1UL, 2UL, 10UL, 1000UL}) {
    const std::vector<double> weights = uneven(n);
    const PiecewiseConstant1D table(weights);
    double sum = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      CHECK(std::abs(table.pmf(i) - weights[i] / table.total()) < 1e-15);
      sum += table.pmf(i);
    }
    CHECK(std::abs(sum - 1) < 1e-14);
  }
}

TEST("a choice is the inverse of the running sum, wherever the number lies") {
  for (const std::size_t n : {1UL, 2UL, 3UL, 10UL, 1000UL}) {
    const PiecewiseConstant1D table(uneven(n));
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit;
    for (int k = 0; k < 20000; ++k) {
      const double u = k % 2 == 0 ? unit(random) : std::floor(unit(random) * double(n)) / double(n);
      const auto got = table.choose(u), want = walked(table, n, u);
      CHECK(std::abs(double(got.index) + got.rest - double(want.index) - want.rest) < 1e-3 || got.index == want.index);
      CHECK(table.pmf(got.index) > 0);
      CHECK(got.rest >= 0 && got.rest <= 1);
    }
  }
}

TEST("evenly spread numbers choose every entry as often as its share says, to one") {
  const std::size_t n = 50, count = 100000;
  std::vector<double> weights(n);
  for (std::size_t i = 0; i < n; ++i) weights[i] = static_cast<double>(1 + i % 5);
  const PiecewiseConstant1D table(weights);
  std::vector<double> chosen(n, 0);
  for (std::size_t k = 0; k < count; ++k) ++chosen[table.choose((double(k) + 0.5) / double(count)).index];
  for (std::uint32_t i = 0; i < n; ++i) CHECK(std::abs(chosen[i] - table.pmf(i) * double(count)) <= 1);
}

TEST("the largest number below one chooses an entry that has a share") {
  const PiecewiseConstant1D table(std::vector<double>{1, 3, 0, 0});
  CHECK(table.choose(std::nextafter(1.0, 0.0)).index == 1);
  CHECK(table.choose(0).index == 0);
}

TEST("weights that are all zero choose the first entry") {
  CHECK(PiecewiseConstant1D(std::vector<double>{0, 0}).choose(0.7).index == 0);
}

}  // namespace

int main() { return check::run(); }
