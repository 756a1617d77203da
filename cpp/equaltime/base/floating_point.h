// Floating-point exceptions of this thread: held back where others' code runs, noticed or trapped where ours does.
#pragma once

#include <cfenv>

namespace equaltime {

/// What no good sample raises; that results are inexact or tiny is no fault.
inline constexpr int kFaults = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;

/// While it lives, nothing is trapped; then the flags, and what is trapped, are what they were before.
class ScopedFpEnvironment {
 public:
  ScopedFpEnvironment() noexcept { std::feholdexcept(&before_); }
  ~ScopedFpEnvironment() { std::fesetenv(&before_); }
  ScopedFpEnvironment(const ScopedFpEnvironment&) = delete;
  ScopedFpEnvironment& operator=(const ScopedFpEnvironment&) = delete;

 private:
  std::fenv_t before_;
};

/// The faults since this was asked last.
[[nodiscard]] inline int take_faults() noexcept {
  const int raised = std::fetestexcept(kFaults);
  if (raised != 0) std::feclearexcept(kFaults);
  return raised;
}

}  // namespace equaltime
