// Multiple importance sampling of two techniques that each take one sample (Veach 1997).
// Weights are formed from the ratio of the pdfs: no square of a pdf can overflow or vanish, and w(a,b) + w(b,a) = 1.
#pragma once

#include <cstdint>

namespace equaltime {

enum class Heuristic : std::uint8_t { balance, power };

/// Weight of a sample drawn with density `pdf` when another technique would have drawn it with density `other`.
/// Both in the same measure; pdf > 0, other >= 0, both finite: discrete events never come here.
[[nodiscard]] constexpr float mis_weight(Heuristic heuristic, float pdf, float other) noexcept {
  const float ratio = other / pdf;
  return 1.0F / (1.0F + (heuristic == Heuristic::power ? ratio * ratio : ratio));
}

}  // namespace equaltime
