// Optional: std::optional for the small values of the path loop. It holds no union, so that compilers keep the parts in
// registers; through std::optional they went to memory and back, which cost a tenth of a render.
#pragma once

#include <optional>

namespace equaltime {

template <class T>
class Optional {
 public:
  constexpr Optional() noexcept = default;
  constexpr Optional(std::nullopt_t) noexcept {}
  constexpr Optional(const T& value) noexcept : value_(value), engaged_(true) {}

  [[nodiscard]] constexpr explicit operator bool() const noexcept { return engaged_; }
  [[nodiscard]] constexpr bool has_value() const noexcept { return engaged_; }
  [[nodiscard]] constexpr const T& operator*() const noexcept { return value_; }
  [[nodiscard]] constexpr T& operator*() noexcept { return value_; }
  [[nodiscard]] constexpr const T* operator->() const noexcept { return &value_; }
  [[nodiscard]] constexpr T* operator->() noexcept { return &value_; }

 private:
  T value_{};
  bool engaged_ = false;
};

}  // namespace equaltime
