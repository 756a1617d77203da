// The effects that a scene calls for.
#pragma once

#include "equaltime/base/effects.h"
#include "equaltime/scene/scene.h"

namespace equaltime {

[[nodiscard]] Effects derive_effects(const Scene& scene) noexcept;

}  // namespace equaltime
