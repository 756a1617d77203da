// Optional: std::optional for the small values of the path loop. It holds no union, so that compilers keep the parts in
// registers; through std::optional they went to memory and back, which cost a tenth of a render. A value of lanes is
// there in some of them. An empty one holds a value too, of defaults: it may be read and written.
#pragma once

#include <concepts>
#include <optional>

#include "equaltime/base/lanes.h"

namespace equaltime {

template <class T>
class Optional {
 public:
  constexpr Optional() noexcept = default;
  constexpr Optional(std::nullopt_t) noexcept {}
  constexpr Optional(const T& value) noexcept : value_(value), engaged_(true) {}
  /// The value where the mask is true.
  constexpr Optional(const T& value, MaskOf<T> engaged) noexcept : value_(value), engaged_(engaged) {}

  [[nodiscard]] constexpr explicit operator bool() const noexcept requires std::same_as < MaskOf<T>,
  bool > { return engaged_; }
  [[nodiscard]] constexpr MaskOf<T> has_value() const noexcept { return engaged_; }
  [[nodiscard]] constexpr const T& operator*() const noexcept { return value_; }
  [[nodiscard]] constexpr T& operator*() noexcept { return value_; }
  [[nodiscard]] constexpr const T* operator->() const noexcept { return &value_; }
  [[nodiscard]] constexpr T* operator->() noexcept { return &value_; }

 private:
  T value_{};
  MaskOf<T> engaged_ = false;
};

}  // namespace equaltime
