#include "equaltime/io/ply.h"
#include "tests/fuzz/fuzz_mesh.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return equaltime::fuzz_reader(data, size, [](const auto& path) { return equaltime::read_ply(path); });
}
