#include "equaltime/transport/kernel.h"

#include <utility>

#include "equaltime/base/effects.h"
#include "equaltime/transport/kernel_effects.h"

namespace equaltime {

namespace {

template <std::size_t... Rows>
std::vector<Kernel> make_kernels(std::index_sequence<Rows...>) {
  return {make_kernel<Rows>()...};
}

}  // namespace

const std::vector<Kernel>& compiled_kernels() noexcept {
  static const std::vector<Kernel> kernels = make_kernels(std::index_sequence<EQUALTIME_KERNEL_ROWS>());
  return kernels;
}

const Kernel& choose_kernel(const Effects& need) noexcept {
  for (const Kernel& kernel : compiled_kernels())
    if (kernel.effects.covers(need)) return kernel;
  return compiled_kernels().back();
}

std::string kernel_name(const Effects& e) {
  std::string name;
  for (const auto& [used, word] : kEffectFields) {
    if (!(e.*used)) continue;
    if (!name.empty()) name += '+';
    name += word;
  }
  return name.empty() ? "diffuse meshes" : name;
}

}  // namespace equaltime
