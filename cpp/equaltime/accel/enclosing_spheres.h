// EnclosingSpheres: spheres so large that their boxes hold all that is smaller, such as the sides of a room whose walls
// are balls. In a tree every ray would visit them; beside it they are met two at a time, without its steps and calls
// back. The nearest is so by float64, the first of those that are equally near.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "equaltime/shapes/geometry.h"

namespace equaltime {

class EnclosingSpheres {
 public:
  EnclosingSpheres() = default;
  EnclosingSpheres(const std::vector<Sphere<float>>& spheres, const std::vector<TriangleMesh>& meshes);

  [[nodiscard]] bool empty() const noexcept { return pairs_.empty(); }
  /// The number of the nearest that the ray meets before its t_max.
  [[nodiscard]] Optional<std::uint32_t> nearest(const RayD& ray) const noexcept {
    Lanes nearest = ray.t_max + Lanes{};
    Mask pair{-1, -1};
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const Lanes t = meet(pairs_[i], ray);
      const Mask nearer = t < nearest;
      nearest = nearer ? t : nearest;
      pair = nearer ? static_cast<std::int64_t>(i) + Mask{} : pair;
    }
    const auto number = [&](std::size_t k) noexcept { return pairs_[static_cast<std::size_t>(pair[k])].numbers[k]; };
    if (pair[0] < 0 && pair[1] < 0) return std::nullopt;
    if (nearest[0] == nearest[1]) return std::min(number(0), number(1));
    return number(nearest[1] < nearest[0] ? 1 : 0);
  }
  /// Whether the ray meets one of them before its t_max.
  [[nodiscard]] bool any(const RayD& ray) const noexcept {
    Mask met{};
    for (const Pair& pair : pairs_) met |= meet(pair, ray) < ray.t_max + Lanes{};
    return (met[0] | met[1]) != 0;
  }
  /// The spheres, by the same numbers, with nothing in the place of walls.
  [[nodiscard]] std::vector<Sphere<float>> taken_out_of(std::vector<Sphere<float>> spheres) const {
    for (const Pair& pair : pairs_)
      for (const std::uint32_t i : pair.numbers) spheres[i].radius = -kInfinity;  // has no box: Embree leaves it out
    return spheres;
  }

 private:
  /// One number of each of two walls (a vector extension of GCC and Clang, SSE on x86).
  using Lanes = double __attribute__((vector_size(16)));
  using Mask = std::int64_t __attribute__((vector_size(16)));
  struct Pair {
    Vec3<Lanes> center;
    Lanes radius;
    std::array<std::uint32_t, 2> numbers;
  };
  /// `intersect` of both by the same operations, whatever t_max is, infinite for none. Which of the walls of a
  /// room a ray comes near cannot be foreseen, so nothing branches on it.
  [[nodiscard]] EQUALTIME_INLINE static Lanes meet(const Pair& pair, const RayD& ray) noexcept {
    const Lanes zero{}, one = 1 + zero;
    const auto both = [](const Vec3d& v) noexcept { return Vec3<Lanes>{v.x + Lanes{}, v.y + Lanes{}, v.z + Lanes{}}; };
    const Vec3<Lanes> oc = both(ray.origin) - pair.center, d = both(ray.direction);
    const Lanes b = -dot(oc, d), a = length_squared(ray.direction) + zero;
    const Lanes discriminant = pair.radius * pair.radius - length_squared(oc + d * (b / a));
    const Mask real = discriminant >= 0;
    const Lanes distance = square_root(length_squared(oc)), half = square_root(a * (real ? discriminant : zero));
    const Lanes c = (distance - pair.radius) * (distance + pair.radius),
                q = reinterpret_cast<Mask>(b) < 0 ? b - half : b + half;
    const Lanes t0 = q != 0 ? c / (q != 0 ? q : one) : zero, t1 = q / a;
    const Lanes first = t0 > t1 ? t1 : t0, second = t0 > t1 ? t0 : t1, t = first > 0 ? first : second;
    return (real & (t > 0)) ? t : static_cast<double>(kInfinity) + zero;
  }
  [[nodiscard]] static Lanes square_root(Lanes v) noexcept { return Lanes{std::sqrt(v[0]), std::sqrt(v[1])}; }

  std::vector<Pair> pairs_;  // in ascending order of numbers; if they are odd, the last stands there twice
};

}  // namespace equaltime
