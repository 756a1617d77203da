// Checked samples: the same bits as a kernel's, watched for floating-point faults in our own code. Embree is not
// watched, because it raises faults on good rays; nor are the intersections of spheres, disks and cylinders that Embree
// calls.
#pragma once

#include <string>

#include "equaltime/base/floating_point.h"
#include "equaltime/transport/kernel.h"

namespace equaltime {

/// Handling of floating-point faults: ignore them; check for them and log the samples; or stop the process at the first
/// one (SIGFPE), for a debugger to show.
enum class Traps : std::uint8_t { ignore, check, stop };

/// A sample that raised faults, whatever its value; x, y within the crop.
struct FaultySample {
  std::uint32_t x, y;
  std::uint64_t index;
  int faults;  // of <cfenv>
};

/// Renders a block like Kernel::render, but slower.
void render_checked(const BlockTask& task, Traps traps, Film& film, RayCounter& counter,
                    SampleLog<NonFinite>& nonfinite, SampleLog<FaultySample>& faulty);

/// Names of the faults, joined with commas.
[[nodiscard]] std::string fault_names(int faults);

}  // namespace equaltime
