// A phase function of a table: values at evenly spaced cosines of the angle by which light is turned, and straight
// lines between them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <tuple>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/base/fields.h"
#include "equaltime/base/optional.h"
#include "equaltime/math/elementary.h"
#include "equaltime/sampling/piecewise_constant_1d.h"
#include "equaltime/sampling/scattering.h"

namespace equaltime {

struct TabulatedPhaseDescription {
  std::vector<double> values;  // from light that turns back, where the cosine is -1, to light that goes straight on

  friend bool operator==(const TabulatedPhaseDescription&, const TabulatedPhaseDescription&) = default;
};

class TabulatedPhase {
 public:
  using Description = TabulatedPhaseDescription;
  static constexpr const char* name = "tabphase";
  static constexpr bool Effects::*needs = &Effects::phase_blends;
  static constexpr bool is_delta = false;
  static constexpr bool transmits = true;
  static constexpr bool picks_lobe = false;
  Spectrum single_albedo{1, 1, 1};

  explicit TabulatedPhase(const Description& d) : table_(std::make_shared<const Table>(d.values)) {}
  [[nodiscard]] static constexpr auto fields() noexcept {
    return std::tuple{Field{"values", &Description::values, kCoefficient}};
  }
  [[nodiscard]] static const char* problem(const Description& d) noexcept {
    const bool shines = std::ranges::any_of(d.values, [](double value) { return value > 0; });
    return d.values.size() < 2 || !shines ? "values has at least two numbers, one of them above 0" : nullptr;
  }

  [[nodiscard]] BsdfValue<float> eval(const Vec3f&, const Vec3f& wi, bool) const noexcept {
    const double place = 0.5 * (1 - static_cast<double>(wi.z)) * table_->bins();  // light that goes on has z = -1
    const double whole = std::clamp(std::floor(place), 0.0, table_->bins() - 1);
    const auto* node = &table_->density[static_cast<std::size_t>(whole)];
    const auto pdf = static_cast<float>(std::max(0.0, node[0] + (node[1] - node[0]) * (place - whole)));
    return {Spectrum(pdf), pdf};
  }

  [[nodiscard]] Optional<BsdfSample<float>> sample(const Vec3f& wo, bool front, double, Point2f u) const noexcept {
    const auto [bin, rest] = table_->masses.choose(static_cast<double>(u.x));
    // The part of the bin whose mass is `rest` of all: the root of a quadratic, in a form that divides by no
    // difference.
    const double first = table_->density[bin], last = table_->density[bin + 1];
    const double root = std::sqrt(first * first + (last - first) * (last + first) * rest);
    const double part = first + root > 0 ? rest * (first + last) / (first + root) : 0;
    const double cosine = std::clamp(2 * (bin + part) / table_->bins() - 1, -1.0, 1.0);
    const auto sine = static_cast<float>(std::sqrt((1 - cosine) * (1 + cosine)));
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);
    const Vec3f wi{sine * cos_phi, sine * sin_phi, static_cast<float>(-cosine)};
    return BsdfSample<float>{wi, Spectrum(1), eval(wo, wi, front).pdf};
  }

  [[nodiscard]] Spectrum albedo(const Vec3f&, bool) const noexcept { return single_albedo; }

 private:
  struct Table {
    std::vector<double> density;  // per solid angle, at the nodes
    PiecewiseConstant1D masses;   // of the bins between them

    explicit Table(const std::vector<double>& values) : density(values) {
      const double most = *std::ranges::max_element(values);  // no sum overflows
      for (double& value : density) value /= most;
      std::vector<double> means;
      for (std::size_t i = 0; i + 1 < density.size(); ++i) means.push_back(0.5 * (density[i] + density[i + 1]));
      masses = PiecewiseConstant1D(means);
      const double all = 4 * std::numbers::pi * masses.total() / bins();  // a bin of cosines has 4π/n of the sphere
      for (double& value : density) value /= all;
    }
    [[nodiscard]] double bins() const noexcept { return static_cast<double>(density.size() - 1); }
  };
  std::shared_ptr<const Table> table_;
};

}  // namespace equaltime
