// Pearson's χ² as a standard normal deviate, for tests with fixed seeds and a stated false-alarm rate.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace statistics {

/// Above this a test rejects; a right subject gets there once in 3.5 million fresh seeds.
inline constexpr double kReject = 5;

/// The χ² statistic of counts against expected counts (each about 5 or more) on the scale of a standard normal
/// (Wilson & Hilferty 1931; good to a few percent of a deviate from 10 degrees of freedom on).
inline double chi_squared_deviate(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi_squared = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double difference = counts[i] - expected[i];
    chi_squared += difference * difference / expected[i];
  }
  const double freedom = static_cast<double>(counts.size()) - 1;
  const double spread = 2 / (9 * freedom);
  return (std::cbrt(chi_squared / freedom) - (1 - spread)) / std::sqrt(spread);
}

}  // namespace statistics
