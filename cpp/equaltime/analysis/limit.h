// The limit ratio: the time that Embree alone needs to trace the very rays that a render traced, over the render's
// time. What is missing to 1 is all that the renderer does besides tracing rays. Both sides are timed in turn in one
// run, with the same threads, flags and order of blocks, so that a drifting machine hurts them alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "equaltime/base/effects.h"
#include "equaltime/render/renderer.h"

namespace equaltime {

struct LimitOptions {
  std::uint64_t samples = 16;              // of every pixel, in each pair
  std::uint32_t pairs = 9;                 // each takes the samples that follow those of the pair before
  std::size_t memory_bytes = 512U << 20U;  // of rays kept at a time; a render with more is replayed in parts
  bool replay_first = false;               // what the first pair times first; the next pair does it the other way round
};

/// One render and one replay of its rays.
struct LimitPair {
  double render_seconds = 0;
  double replay_seconds = 0;
  Counters counters;        // of the render
  std::uint64_t found = 0;  // replayed rays that met something

  [[nodiscard]] double ratio() const noexcept { return replay_seconds / render_seconds; }
};

struct Limit {
  std::vector<LimitPair> pairs;
  unsigned threads = 0;
  Effects kernel;  // what the kernel that rendered covers
};

/// Renders and replays in turn. `poll` is called about every 50 ms by the calling thread and ends it all by throwing.
/// Recording the rays is not timed. Throws std::logic_error if the recorded rays are not as many as the render's.
[[nodiscard]] Limit measure_limit(std::shared_ptr<const Scene> scene, const Settings& settings,
                                  const RenderOptions& render, const LimitOptions& options, const Poll& poll = {});

}  // namespace equaltime
