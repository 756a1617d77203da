// Gauss-Legendre quadrature over [0, 1], for tables made at load.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "equaltime/math/elementary.h"

namespace equaltime {

struct QuadratureNode {
  double x, weight;
};

/// n nodes, exact for polynomials of degree up to 2n - 1. Newton's method on the Legendre polynomial of degree n.
[[nodiscard]] inline std::vector<QuadratureNode> gauss_legendre(int n) {
  std::vector<QuadratureNode> nodes;
  for (int i = 0; i < n; ++i) {
    double x = elementary::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1;
    for (int step = 0; step < 6; ++step) {
      double p = 1, before = 0;
      for (int k = 1; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p, p = next;
      }
      derivative = n * (x * p - before) / (x * x - 1);
      x -= p / derivative;
    }
    nodes.push_back({0.5 * (1 - x), 1 / ((1 - x * x) * derivative * derivative)});
  }
  return nodes;
}

}  // namespace equaltime
