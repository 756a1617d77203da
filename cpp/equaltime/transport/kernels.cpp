#include "equaltime/transport/kernels.h"

#include <utility>

#include "equaltime/base/effects.h"
#include "equaltime/transport/kernel_rows.h"

namespace equaltime {

namespace {

template <std::size_t... Rows>
std::vector<KernelRow> rows_of(std::index_sequence<Rows...>) {
  return {kernel_row<Rows>()...};
}

}  // namespace

const std::vector<KernelRow>& kernel_rows() noexcept {
  static const std::vector<KernelRow> rows = rows_of(std::index_sequence<EQUALTIME_KERNEL_ROWS>());
  return rows;
}

const KernelRow& choose_kernel(const Effects& need) noexcept {
  for (const KernelRow& row : kernel_rows())
    if (row.effects.covers(need)) return row;
  return kernel_rows().back();
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
