// The instruction set of Embree's traversal, which is a part of the bits: AVX2 and AVX-512 fuse multiplications.
#pragma once

#include <string>

namespace equaltime {

/// Holds Embree to an instruction set in all scenes built from now on: sse4.2, avx, avx2 or avx512.
/// Throws std::invalid_argument for others, and for those that this machine does not have.
void hold_embree(const std::string& isa);

/// The instruction set that Embree takes in scenes built from now on: the one it is held to, or the machine's best.
[[nodiscard]] std::string embree_isa();

/// The configuration of Embree's devices that says so.
[[nodiscard]] std::string embree_config();

}  // namespace equaltime
