// Checked samples: the same bits as any kernel's, watched for floating-point faults in our own code. Embree, which
// raises them on good rays, is left out, and with it the first look at spheres, disks and cylinders, which runs inside
// it.
#pragma once

#include <string>

#include "equaltime/base/floating_point.h"
#include "equaltime/transport/kernel.h"

namespace equaltime {

/// What becomes of faults: nothing; they are noted, with the sample; or the first ends the process where it happens
/// (SIGFPE), for a debugger to show.
enum class Traps : std::uint8_t { ignore, check, stop };

/// A sample that raised faults, whatever its value; x, y within the crop.
struct FaultySample {
  std::uint32_t x, y;
  std::uint64_t index;
  int faults;  // of <cfenv>
};

/// As the kernels that do not look; slower than these.
void render_checked(const BlockTask& task, Traps traps, Film& film, RayCounter& counter,
                    SampleLog<NonFinite>& nonfinite, SampleLog<FaultySample>& faulty);

/// In words, joined with commas.
[[nodiscard]] std::string fault_names(int faults);

}  // namespace equaltime
