#include "equaltime/render/checked.h"

#include "equaltime/base/effects.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

/// Counts as RayCounter does, and holds faults of Embree back.
class CheckedCounter : public PathObserver {
 public:
  using Guard = ScopedFpEnvironment;

  explicit CheckedCounter(RayCounter& counter) noexcept : counter_(counter) {}

  template <class Event>
  requires Observes<RayCounter, Event>
  void on(const Event& event) noexcept { counter_.on(event); }
  bool cancelled() noexcept { return counter_.cancelled(); }

 private:
  RayCounter& counter_;
};

}  // namespace

void render_checked(const BlockTask& task, Traps traps, Film& film, RayCounter& counter,
                    SampleLog<NonFinite>& nonfinite, SampleLog<FaultySample>& faulty) {
  const ScopedFpEnvironment held;  // so that this thread's own settings come back
  CheckedCounter checked(counter);
  const auto sample = [&](std::uint32_t x, std::uint32_t y, std::uint64_t index) {
    std::feclearexcept(kFaults);
    if (traps == Traps::stop) feenableexcept(kFaults);
    const Spectrum L = sample_pixel<kAllEffects>(task, x, y, index, checked);
    if (traps == Traps::stop) fedisableexcept(kFaults);
    if (const int faults = take_faults(); faults != 0) faulty.add({x, y, index, faults});
    return L;
  };
  render_samples(task, film, counter, nonfinite, sample);
}

std::string fault_names(int faults) {
  std::string names;
  for (const auto& [fault, name] : {std::pair{FE_INVALID, "invalid operation"},
                                    std::pair{FE_DIVBYZERO, "division by zero"}, std::pair{FE_OVERFLOW, "overflow"}})
    if (faults & fault) names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

}  // namespace equaltime
