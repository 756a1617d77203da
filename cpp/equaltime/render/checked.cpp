#include "equaltime/render/checked.h"

#include "equaltime/base/effects.h"
#include "equaltime/transport/sample_pixel.h"

namespace equaltime {

namespace {

/// Counts as RayCounter does, and holds faults of Embree back.
class CheckedCounter {
 public:
  static constexpr bool listens = false;
  static constexpr bool allocates = false;

  explicit CheckedCounter(RayCounter& counter) noexcept : counter_(counter) {}

  template <Effects E>
  [[nodiscard]] MeetingOf<E> intersect(const Scene& scene, const Ray& ray) noexcept {
    ++counter_.counters.rays;
    return scene.intersect<E, HeldExceptions>(ray, time);
  }
  template <Effects E>
  [[nodiscard]] bool occluded(const Scene& scene, const Ray& ray) noexcept {
    const HeldExceptions held;
    ++counter_.counters.shadow_rays;
    return scene.occluded<E>(ray, time);
  }
  template <Effects E>
  [[nodiscard]] MeetingOf<E> blocker(const Scene& scene, const Ray& ray) noexcept {
    ++counter_.counters.shadow_rays;
    return scene.intersect<E, HeldExceptions>(ray, time);
  }
  void begin(float weight) noexcept { counter_.begin(weight); }
  static void scatters(const Bsdf&) noexcept {}
  static void aims(const LightSample&) noexcept {}
  static Spectrum met(const Spectrum& L, std::uint32_t, int) noexcept { return L; }
  static Spectrum lit(const Spectrum& L, int) noexcept { return L; }
  bool gives_up() noexcept { return counter_.gives_up(); }

  float time = 0;  // as RayCounter's

 private:
  RayCounter& counter_;
};

}  // namespace

void render_checked(const BlockTask& task, Traps traps, Film& film, RayCounter& counter,
                    SampleLog<NonFinite>& nonfinite, SampleLog<FaultySample>& faulty) {
  const HeldExceptions held;  // so that this thread's own settings come back
  CheckedCounter probe(counter);
  const auto sample = [&](std::uint32_t x, std::uint32_t y, std::uint64_t index) {
    std::feclearexcept(kFaults);
    if (traps == Traps::stop) feenableexcept(kFaults);
    const Spectrum L = sample_pixel<kAllEffects>(task, x, y, index, probe);
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
