// Media, from their description to normalised space.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "equaltime/build/description.h"
#include "equaltime/math/normalization.h"
#include "equaltime/media/medium.h"
#include "equaltime/media/phase_function.h"

namespace equaltime {

/// The media of a description. Those of no extinction are resolve_constant_blend into vacuum.
struct Media {
  std::vector<Medium> dense;
  std::vector<PhaseFunction> phases;  // of each of these, its phase function
  std::vector<std::uint32_t> index;   // of each of the description, in `dense`; kNone if it is vacuum

  /// Throws std::invalid_argument if the description has no medium of this number.
  [[nodiscard]] std::uint32_t at(const std::optional<std::uint32_t>& described) const;
};

/// Throws std::invalid_argument for numbers that make no sense.
[[nodiscard]] Media make_media(const std::vector<MediumDescription>& descriptions, const Normalization& normalization);

}  // namespace equaltime
