#include "equaltime/math/motion.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <new>
#include <stdexcept>

#include "equaltime/math/elementary.h"

namespace equaltime {

namespace {

/// Below this angle, in radians, a chord is as good as the arc.
constexpr double kStraight = 1e-9;
/// Parts of the shutter are short enough when what is in them strays no more than this part of its size.
constexpr double kSlack = 0.02;
constexpr unsigned kMostParts = 64;

struct Linear {
  Vec3d x, y, z;  // columns
};

double determinant(const Linear& m) noexcept { return dot(m.x, cross(m.y, m.z)); }
double largest(const Linear& m) noexcept {
  return std::max(max_component(abs(m.x)), std::max(max_component(abs(m.y)), max_component(abs(m.z))));
}

/// The rotation nearest to a matrix of positive determinant (Higham 1986): the mean of it and of its transposed
/// inverse, again and again. What is far from a rotation takes a step for each binary digit, and then a few.
Linear nearest_rotation(const Linear& m) noexcept {
  const double scale = std::ldexp(1.0, -std::ilogb(largest(m)));
  Linear r{m.x * scale, m.y * scale, m.z * scale};
  for (int i = 0; i < 200; ++i) {
    const double inverse = 1 / determinant(r);
    const Linear next{(r.x + cross(r.y, r.z) * inverse) * 0.5, (r.y + cross(r.z, r.x) * inverse) * 0.5,
                      (r.z + cross(r.x, r.y) * inverse) * 0.5};
    const double change = largest({next.x - r.x, next.y - r.y, next.z - r.z});
    r = next;
    if (change < 1e-15) break;
  }
  return r;
}

double norm(const Vec3d& stretch, const Vec3d& shear) noexcept {
  return std::sqrt(length_squared(stretch) + 2 * length_squared(shear));
}

/// Never 0.
std::uint64_t new_id() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

template <class F>
void for_corners(const Bounds& b, F&& f) noexcept {
  for (const double x : {b.lo.x, b.hi.x})
    for (const double y : {b.lo.y, b.hi.y})
      for (const double z : {b.lo.z, b.hi.z}) f(Vec3d{x, y, z});
}

}  // namespace

AffineMap::AffineMap(const Vec3d& x, const Vec3d& y, const Vec3d& z, const Vec3d& at) noexcept
    : columns{x, y, z}, origin(at) {
  const double inverse = 1 / dot(x, cross(y, z));
  rows[0] = cross(y, z) * inverse, rows[1] = cross(z, x) * inverse, rows[2] = cross(x, y) * inverse;
}

Motion::Pose Motion::pose_of(const MotionKey& key, bool mirrored) {
  const Transform& t = key.to_world;
  Linear m{t.column(0), t.column(1), t.column(2) * (mirrored ? -1.0 : 1.0)};
  const double size = determinant(m);
  if (!(size > 0) || !std::isfinite(size) || !is_finite(t.column(3)) || !std::isfinite(key.time))
    throw std::invalid_argument("the keys of a motion must be finite, have an inverse, and all mirror or none of them");
  const auto [rx, ry, rz] = nearest_rotation(m);
  const Vec3d stretch{dot(rx, m.x), dot(ry, m.y), dot(rz, m.z)};
  const Vec3d shear =
      Vec3d{dot(ry, m.z) + dot(rz, m.y), dot(rz, m.x) + dot(rx, m.z), dot(rx, m.y) + dot(ry, m.x)} * 0.5;
  // The largest of the four is taken from the diagonal, the others from what is off it (Shepperd 1978).
  const double trace = rx.x + ry.y + rz.z;
  const double squares[4] = {trace, rx.x, ry.y, rz.z};
  const auto which = std::max_element(squares, squares + 4) - squares;
  Quaternion q{};
  if (which == 0)
    q = {1 + trace, ry.z - rz.y, rz.x - rx.z, rx.y - ry.x};
  else if (which == 1)
    q = {ry.z - rz.y, 1 + rx.x - ry.y - rz.z, rx.y + ry.x, rz.x + rx.z};
  else if (which == 2)
    q = {rz.x - rx.z, rx.y + ry.x, 1 + ry.y - rx.x - rz.z, ry.z + rz.y};
  else
    q = {rx.y - ry.x, rz.x + rx.z, ry.z + rz.y, 1 + rz.z - rx.x - ry.y};
  const double unit = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {key.time, t.column(3), {q.w * unit, q.x * unit, q.y * unit, q.z * unit}, stretch, shear};
}

Motion::Motion(const std::vector<MotionKey>& keys) : id_(new_id()) {
  if (keys.empty()) throw std::invalid_argument("a motion needs a key");
  const Transform& first = keys.front().to_world;
  mirrored_ = determinant({first.column(0), first.column(1), first.column(2)}) < 0;
  for (const MotionKey& key : keys) {
    Pose pose = pose_of(key, mirrored_);
    if (!poses_.empty()) {
      Pose& last = poses_.back();
      if (!(pose.time > last.time)) throw std::invalid_argument("the times of the keys of a motion must increase");
      Quaternion &a = last.turn, &b = pose.turn;
      if (a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0) b = {-b.w, -b.x, -b.y, -b.z};  // the shorter way
      const auto apart = [&](double sign) {
        const double w = b.w + sign * a.w, x = b.x + sign * a.x, y = b.y + sign * a.y, z = b.z + sign * a.z;
        return std::sqrt(w * w + x * x + y * y + z * z);
      };
      last.angle = 2 * elementary::atan2(apart(-1), apart(1));
      if (last.angle > kStraight) last.unit = 1 / elementary::sin(last.angle);
    }
    poses_.push_back(pose);
  }
}

Motion Motion::between(const Space& own, const Space& world) const {
  Motion motion = *this;
  motion.id_ = new_id();
  const double scale = world.scale / own.scale;
  for (Pose& pose : motion.poses_) {
    pose.position = (pose.position - world.origin) * world.scale;
    pose.stretch = pose.stretch * scale, pose.shear = pose.shear * scale;
  }
  motion.pivot_ = own.origin * own.scale;
  return motion;
}

AffineMap Motion::placed(const Vec3d& position, const Quaternion& turn, const Vec3d& s, const Vec3d& h) const noexcept {
  const auto& [w, x, y, z] = turn;
  const Vec3d rx{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
  const Vec3d ry{2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
  const Vec3d rz{2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
  const Vec3d a = rx * s.x + ry * h.z + rz * h.y, b = rx * h.z + ry * s.y + rz * h.x;
  Vec3d c = rx * h.y + ry * h.x + rz * s.z;
  if (mirrored_) c = -c;
  return {a, b, c, position + a * pivot_.x + b * pivot_.y + c * pivot_.z};
}

AffineMap Motion::at(double time) const noexcept {
  struct Kept {
    std::uint64_t motion = 0;  // the id of none
    double time = 0;
    AffineMap placement{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {}};
  };
  constexpr std::size_t kKept = 16;  // instances that a ray comes near, in most scenes; four bits of a hash
  using Recent = std::array<Kept, kKept>;
  // On the heap: a library that is loaded late has room for a few bytes a thread only.
  thread_local const std::unique_ptr<Recent> recent(new (std::nothrow) Recent);
  if (!recent) return computed_at(time);
  Kept& kept = (*recent)[(id_ * 0x9E3779B97F4A7C15ULL) >> 60];  // Fibonacci hashing: ids in use may be all even
  if (kept.motion != id_ || kept.time != time) kept = {id_, time, computed_at(time)};
  return kept.placement;
}

AffineMap Motion::computed_at(double time) const noexcept {
  const auto later = [](double now, const Pose& pose) { return now < pose.time; };
  const auto next =
      static_cast<std::size_t>(std::upper_bound(poses_.begin(), poses_.end(), time, later) - poses_.begin());
  if (next == 0 || next == poses_.size()) {
    const Pose& only = poses_[next == 0 ? 0 : next - 1];
    return placed(only.position, only.turn, only.stretch, only.shear);
  }
  const Pose &a = poses_[next - 1], &b = poses_[next];
  const double f = (time - a.time) / (b.time - a.time);
  double from = 1 - f, to = f;
  const auto mixed = [&](const auto& u, const auto& v) { return u * (1 - f) + v * f; };
  const Vec3d position = mixed(a.position, b.position), stretch = mixed(a.stretch, b.stretch);
  const Vec3d shear = mixed(a.shear, b.shear);
  if (a.angle > kStraight)
    from = elementary::sin((1 - f) * a.angle) * a.unit, to = elementary::sin(f * a.angle) * a.unit;
  const Quaternion &p = a.turn, &q = b.turn;
  const Quaternion turn{p.w * from + q.w * to, p.x * from + q.x * to, p.y * from + q.y * to, p.z * from + q.z * to};
  return placed(position, turn, stretch, shear);
}

bool Motion::turns() const noexcept {
  for (std::size_t i = 0; i + 1 < poses_.size(); ++i) {
    const Pose &a = poses_[i], &b = poses_[i + 1];
    if (a.angle > 0 || !(a.stretch == b.stretch) || !(a.shear == b.shear)) return true;
  }
  return false;
}

Bounds Motion::bounds_at(const Bounds& local, double time) const noexcept {
  Bounds bounds;
  const AffineMap placement = at(time);
  for_corners(local, [&](const Vec3d& p) { bounds.include(placement.point(p)); });
  return bounds;
}

/// Between two keys a point p(t) = T(t) + R(t) S(t) x has |p''| <= (ω² |S| + 2 ω |S'|) |x|, and strays from its chord
/// over a time h by at most h²/8 of that, and by what the ends of the chord are off.
double Motion::deviation(const Bounds& local, double begin, double end) const noexcept {
  double reach = 0;
  for_corners(local, [&](const Vec3d& p) { reach = std::max(reach, length(p + pivot_)); });
  const AffineMap first = at(begin), last = at(end);
  const auto off_chord = [&](double time) {
    const double f = (time - begin) / (end - begin);
    const AffineMap now = at(time);
    double most = 0;
    for_corners(local, [&](const Vec3d& p) {
      most = std::max(most, length(now.point(p) - (first.point(p) * (1 - f) + last.point(p) * f)));
    });
    return most;
  };
  double at_keys = 0, within = 0;
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const Pose& a = poses_[i];
    if (begin < a.time && a.time < end) at_keys = std::max(at_keys, off_chord(a.time));
    if (i + 1 == poses_.size()) break;
    const Pose& b = poses_[i + 1];
    const double h = std::min(end, b.time) - std::max(begin, a.time), duration = b.time - a.time;
    if (!(h > 0)) continue;
    const double pace = 2 * a.angle / duration;
    const double size = std::max(norm(a.stretch, a.shear), norm(b.stretch, b.shear));
    const double growth = norm(b.stretch - a.stretch, b.shear - a.shear) / duration;
    within = std::max(within, h * h / 8 * (pace * pace * size + 2 * pace * growth) * reach);
  }
  return at_keys + within;
}

unsigned Motion::parts(const Bounds& local) const noexcept {
  const double size = length(bounds_at(local, 0.5).extent());
  for (unsigned n = 1; n < kMostParts; n *= 2) {
    double most = 0;
    for (unsigned i = 0; i < n; ++i)
      most = std::max(most, deviation(local, static_cast<double>(i) / n, static_cast<double>(i + 1) / n));
    if (most <= kSlack * size) return n;
  }
  return kMostParts;
}

Bounds Motion::swept(const Bounds& local) const noexcept {
  Bounds all;
  const unsigned n = parts(local);
  for (unsigned i = 0; i < n; ++i) {
    const double begin = static_cast<double>(i) / n, end = static_cast<double>(i + 1) / n;
    const double off = deviation(local, begin, end);
    for (const double time : {begin, end}) {
      const Bounds b = bounds_at(local, time);
      all.include(b.lo - Vec3d{off, off, off});
      all.include(b.hi + Vec3d{off, off, off});
    }
  }
  return all;
}

}  // namespace equaltime
