// The alias table: its exact probabilities, read off the bits at which its choice changes, and its extremes.
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "equaltime/sampling/alias_table.h"
#include "tests/check.h"
#include "tests/statistics.h"

namespace {

using namespace equaltime;
using Wide = unsigned __int128;

constexpr std::uint64_t kLast = ~std::uint64_t{0};

std::vector<double> over_decades(std::size_t n, double decades) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> exponent(-decades, 0);
  std::vector<double> weights(n);
  for (double& w : weights) w = std::pow(10, exponent(random));
  return weights;
}

// How many of the 2^64 numbers choose each entry. The numbers of a bin are an interval in which the choice changes once
// at most; the place is found by bisection.
std::vector<long double> exact_shares(const AliasTable& table, std::size_t n) {
  std::vector<long double> shares(n, 0);
  const auto first_of = [n](std::size_t bin) {
    return bin == n ? Wide{1} << 64 : ((static_cast<Wide>(bin) << 64) + n - 1) / n;
  };
  for (std::size_t bin = 0; bin < n; ++bin) {
    const Wide begin = first_of(bin), end = first_of(bin + 1);
    const std::uint32_t own = table.sample(static_cast<std::uint64_t>(begin));
    Wide low = begin, high = end;  // own is chosen at low, not at high
    while (high - low > 1) {
      const Wide middle = low + (high - low) / 2;
      (table.sample(static_cast<std::uint64_t>(middle)) == own ? low : high) = middle;
    }
    shares[own] += static_cast<long double>(high - begin) * 0x1p-64L;
    if (high < end)
      shares[table.sample(static_cast<std::uint64_t>(high))] += static_cast<long double>(end - high) * 0x1p-64L;
  }
  return shares;
}

// A choice is by 64 bits: no share can be finer than that.
constexpr long double kGrain = 4 * 0x1p-64L;

bool shares_follow(const std::vector<double>& weights, const AliasTable& table) {
  const std::vector<long double> shares = exact_shares(table, weights.size());
  long double sum = 0;
  for (const double w : weights) sum += static_cast<long double>(w);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const long double p = static_cast<long double>(weights[i]) / sum;
    if (std::abs(shares[i] - p) > 1e-11L * p + kGrain) return false;
  }
  return true;
}

TEST("probabilities are right to eleven digits for weights over twelve decades") {
  for (const std::size_t n : {1UL, 2UL, 3UL, 10UL, 1000UL, 20000UL}) {
    const std::vector<double> weights = over_decades(n, 12);
    CHECK(shares_follow(weights, AliasTable(weights)));
  }
}

TEST("the same test rejects a table with one weight a millionth too large") {
  std::vector<double> weights = over_decades(1000, 12);
  const std::vector<double> meant = weights;
  weights[17] *= 1.000001;
  CHECK(!shares_follow(meant, AliasTable(weights)));
}

TEST("the stated probability is that of the choice") {
  const std::vector<double> weights = over_decades(5000, 12);
  const AliasTable table(weights);
  const std::vector<long double> shares = exact_shares(table, weights.size());
  for (std::uint32_t i = 0; i < weights.size(); ++i)
    CHECK(std::abs(static_cast<long double>(table.pmf(i)) - shares[i]) <= 0x1p-23L * shares[i] + kGrain);
}

TEST("an entry of weight zero is never chosen, wherever it stands") {
  std::mt19937_64 random(3);
  for (int round = 0; round < 300; ++round) {
    std::vector<double> weights = over_decades(1 + random() % 40, 15);
    for (double& w : weights)
      if (random() % 3 == 0) w = 0;
    weights[random() % weights.size()] = 1;
    const AliasTable table(weights);
    const std::vector<long double> shares = exact_shares(table, weights.size());
    for (std::uint32_t i = 0; i < weights.size(); ++i)
      if (weights[i] == 0) CHECK(shares[i] == 0 && table.pmf(i) == 0);
    for (const std::uint64_t bits : {std::uint64_t{0}, kLast}) {
      const std::uint32_t chosen = table.sample(bits);
      CHECK(chosen < weights.size() && weights[chosen] > 0);
    }
  }
}

TEST("the first and the last number of every bin choose an entry that can be chosen") {
  for (const std::size_t n : {1UL, 3UL, 7UL, 4096UL, 65537UL}) {
    std::vector<double> weights(n, 0);
    weights[n / 2] = 1e-300;
    const AliasTable table(weights);
    for (std::size_t bin = 0; bin <= n; ++bin) {
      const auto edge = static_cast<std::uint64_t>((static_cast<Wide>(bin) << 64) / n);
      for (const std::uint64_t bits : {edge - 1, edge, edge + 1}) CHECK(table.sample(bits) == n / 2);
    }
  }
}

TEST("what can be chosen has a probability above zero, even where float32 has little left") {
  const std::vector<double> weights = {
      1, 1e-12, 1e-19, 1e-30, 1e-60, 1e-300, std::numeric_limits<double>::denorm_min()};
  const AliasTable table(weights);
  const std::vector<long double> shares = exact_shares(table, weights.size());
  for (std::uint32_t i = 0; i < weights.size(); ++i) CHECK(shares[i] == 0 || table.pmf(i) > 0);
}

TEST("weights near the largest number do not overflow, and no weight at all leaves the table empty") {
  const std::vector<double> weights(10, std::numeric_limits<double>::max());
  const AliasTable table(weights);
  for (std::uint32_t i = 0; i < 10; ++i) CHECK(std::abs(table.pmf(i) - 0.1F) < 1e-7F);
  CHECK(AliasTable(std::vector<double>{}).empty());
  CHECK(AliasTable(std::vector<double>(4, 0.0)).empty());
}

TEST("choices follow the weights by a chi-squared test, which sees two percent") {
  const auto deviate = [](std::vector<double> weights, double tilt) {
    const AliasTable table(weights);
    weights[0] *= tilt;
    double sum = 0;
    for (const double w : weights) sum += w;
    std::mt19937_64 random(5);
    constexpr int kDraws = 2000000;
    std::vector<double> counts(weights.size(), 0), expected;
    for (int i = 0; i < kDraws; ++i) ++counts[table.sample(random())];
    for (const double w : weights) expected.push_back(w / sum * kDraws);
    return statistics::chi_squared_deviate(counts, expected);
  };
  std::vector<double> weights;
  for (int i = 1; i <= 20; ++i) weights.push_back(1.0 / i);
  CHECK(std::abs(deviate(weights, 1)) < statistics::kReject);
  CHECK(deviate(weights, 1.02) > statistics::kReject);
}

}  // namespace

int main() { return check::run(); }
