// Three-component vectors over float (rendering) and double (loading, cameras, exact recomputation), and over lanes.
// A point, a direction and a normal are all Vec3: the frame and the unit are said where a value is declared.
#pragma once

#include <cmath>

#include "equaltime/math/numeric.h"

namespace equaltime {

template <class T>
struct Vec3 {
  T x{}, y{}, z{};

  constexpr Vec3() noexcept = default;
  constexpr Vec3(T x_, T y_, T z_) noexcept : x(x_), y(y_), z(z_) {}
  template <class U>
  constexpr explicit Vec3(const Vec3<U>& v) noexcept
      : x(static_cast<T>(v.x)), y(static_cast<T>(v.y)), z(static_cast<T>(v.z)) {}

  constexpr Vec3 operator-() const noexcept { return {-x, -y, -z}; }
  constexpr Vec3& operator+=(const Vec3& v) noexcept { return *this = *this + v; }
  constexpr bool operator==(const Vec3&) const noexcept = default;

  friend constexpr Vec3 operator+(const Vec3& a, const Vec3& b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(const Vec3& a, const Vec3& b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator*(const Vec3& a, T s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
  friend constexpr Vec3 operator*(T s, const Vec3& a) noexcept { return a * s; }
  friend constexpr Vec3 operator/(const Vec3& a, T s) noexcept { return {a.x / s, a.y / s, a.z / s}; }
};

using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T>
constexpr T dot(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
constexpr Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
constexpr T length_squared(const Vec3<T>& a) noexcept {
  return dot(a, a);
}
template <class T>
T length(const Vec3<T>& a) noexcept {
  return sqrt(dot(a, a));
}
template <class T>
Vec3<T> normalize(const Vec3<T>& a) noexcept {
  return a * (T(1) / length(a));
}
template <class T>
Vec3<T> abs(const Vec3<T>& a) noexcept {
  return {abs(a.x), abs(a.y), abs(a.z)};
}
template <class T>
constexpr Vec3<T> min(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
template <class T>
constexpr Vec3<T> max(const Vec3<T>& a, const Vec3<T>& b) noexcept {
  return {max(a.x, b.x), max(a.y, b.y), max(a.z, b.z)};
}
template <class T>
constexpr T max_component(const Vec3<T>& a) noexcept {
  return max(a.x, max(a.y, a.z));
}
inline bool is_finite(const Vec3d& a) noexcept {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

}  // namespace equaltime
