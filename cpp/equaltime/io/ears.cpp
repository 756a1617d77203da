#include "equaltime/io/ears.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>

#include "equaltime/math/elementary.h"

namespace equaltime {
namespace {

// Relative size of a turn that counts as none: a corner on a straight edge, but for rounding.
constexpr double kStraight = 1e-10;
// How many pairs of an ear and a corner one face may take: 0.2 s, which a comb of 8000 corners needs.
constexpr std::uint64_t kMostWork = std::uint64_t{1} << 26;
// How many such pairs all faces of a file may take: some seconds.
constexpr std::uint64_t kMostWorkInAll = std::uint64_t{1} << 30;

struct Point {
  double x, y;
};

bool same(const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; }

// Twice the area of a, b, c: positive if they go round counter-clockwise.
double turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

using Vec = std::array<double, 3>;

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Tells whether a face of four corners goes round to the left at each, far enough from rounding to be seen at once.
bool is_plainly_convex(const MeshData& mesh, const std::uint32_t* fan) {
  std::array<Vec, 4> p;
  for (std::size_t i = 0; i < 4; ++i) {
    const double* const at = mesh.vertices.data() + 3 * std::size_t{fan[i < 3 ? i : 5]};
    p[i] = {at[0], at[1], at[2]};
  }
  const Vec normal = cross(minus(p[2], p[0]), minus(p[3], p[1]));
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec n = cross(minus(p[(i + 1) % 4], p[i]), minus(p[(i + 2) % 4], p[(i + 1) % 4]));
    if (!(n[0] * normal[0] + n[1] * normal[1] + n[2] * normal[2] > 0)) return false;
  }
  return true;
}

// One face at a time; the buffers serve all.
class Cutter {
 public:
  // Takes up the corners of a fan. Returns false for one that has no extent or is not finite.
  bool take(const MeshData& mesh, const FannedFace& face) {
    corners_.clear();
    const std::uint32_t* fan = mesh.faces.data() + 3 * face.first;
    corners_.push_back(fan[0]);
    corners_.push_back(fan[1]);
    for (std::uint64_t i = 0; i < face.triangles; ++i) corners_.push_back(fan[3 * i + 2]);
    return project(mesh);
  }

  [[nodiscard]] bool is_convex() const {
    double turned = 0;
    for (std::size_t i = 0, n = points_.size(); i < n; ++i) {
      const Point &a = points_[i], &b = points_[(i + 1) % n], &c = points_[(i + 2) % n];
      const double ex = b.x - a.x, ey = b.y - a.y, fx = c.x - b.x, fy = c.y - b.y;
      const double sine = ex * fy - ey * fx, cosine = ex * fx + ey * fy;
      const double none = kStraight * elementary::hypot(ex, ey) * elementary::hypot(fx, fy);
      if (sine < -none || (sine <= none && cosine < 0)) return false;
      if (n > 4) turned += elementary::atan2(sine, cosine);  // four turns to the left are one round
    }
    return turned < 3 * std::numbers::pi;
  }

  // Cuts the face into ears, given as places in its corners. Returns false if that cannot be.
  bool cut(std::vector<std::uint32_t>& triangles) {
    if (work_in_all_ > kMostWorkInAll) return false;
    work_ = 0;
    triangles.clear();
    const bool is_cut = !crosses_itself() && cut_ears(triangles);
    work_in_all_ += work_;
    return is_cut;
  }

  [[nodiscard]] std::span<const std::uint32_t> corners() const noexcept { return corners_; }

 private:
  // Brings the corners near 1 by a power of two, and onto the two axes on which the face is largest, counter-clockwise.
  bool project(const MeshData& mesh) {
    placed_.clear();
    double largest = 0;
    const double* const origin = mesh.vertices.data() + 3 * std::size_t{corners_[0]};
    for (const std::uint32_t corner : corners_) {
      const double* p = mesh.vertices.data() + 3 * std::size_t{corner};
      placed_.push_back({p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]});
      for (const double x : placed_.back()) largest = std::isfinite(x) ? std::max(largest, std::abs(x)) : x;
      if (!std::isfinite(largest)) return false;
    }
    if (largest == 0) return false;
    int exponent = 0;
    (void)std::frexp(largest, &exponent);
    for (Vec& p : placed_) {
      for (double& x : p) x = std::ldexp(x, -exponent);
    }
    Vec area = {0, 0, 0}, size = {0, 0, 0};
    for (std::size_t i = 1; i + 1 < placed_.size(); ++i) {
      const Vec n = cross(placed_[i], placed_[i + 1]);
      for (std::size_t k = 0; k < 3; ++k) area[k] += n[k], size[k] += std::abs(n[k]);
    }
    const auto axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
    if (size[axis] == 0) return false;
    const std::size_t x = (axis + (area[axis] < 0 ? 2 : 1)) % 3, y = (axis + (area[axis] < 0 ? 1 : 2)) % 3;
    points_.clear();
    for (const Vec& p : placed_) points_.push_back({p[x], p[y]});
    return true;
  }

  bool crosses_itself() {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i + 2 < n; ++i) {
      const Point &a = points_[i], &b = points_[i + 1];
      for (std::size_t j = i + 2; j < n; ++j) {
        if (++work_ > kMostWork) return true;
        const Point &c = points_[j], &d = points_[(j + 1) % n];
        if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) return true;
      }
    }
    return false;
  }

  bool cut_ears(std::vector<std::uint32_t>& triangles) {
    const std::size_t n = points_.size();
    before_.resize(n), after_.resize(n);
    for (std::size_t i = 0; i < n; ++i) before_[i] = (i + n - 1) % n, after_[i] = (i + 1) % n;
    std::size_t left = n, at = 1, passed = 0;
    bool flat = false;  // whether corners on a straight edge are cut off: only where there is no other ear
    while (left > 2) {
      if (is_ear(at, flat)) {
        const std::size_t a = before_[at], c = after_[at];
        for (const std::size_t corner : {a, at, c}) triangles.push_back(static_cast<std::uint32_t>(corner));
        after_[a] = c, before_[c] = a;
        at = after_[c];  // the next ear is elsewhere: fewer slivers
        --left, passed = 0, flat = false;
      } else if (++passed > left) {
        if (flat || work_ > kMostWork) return false;
        flat = true, passed = 0;
      } else {
        at = after_[at];
      }
    }
    return true;
  }

  bool is_ear(std::size_t at, bool flat) {
    const Point &a = points_[before_[at]], &b = points_[at], &c = points_[after_[at]];
    const double area = turn(a, b, c);
    if (area < 0 || (area == 0 && !flat)) return false;
    if (area == 0) return true;
    for (std::size_t i = after_[after_[at]]; i != before_[at]; i = after_[i]) {
      const Point& p = points_[i];
      if (++work_ > kMostWork) return false;
      // A face with a hole passes twice along the edge that joins the hole with its outline.
      if (same(p, a) || same(p, b) || same(p, c)) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
    }
    return true;
  }

  std::vector<std::uint32_t> corners_;
  std::vector<Vec> placed_;
  std::vector<Point> points_;
  std::vector<std::size_t> before_, after_;
  std::uint64_t work_ = 0, work_in_all_ = 0;
};

}  // namespace

UncutFaces cut_concave_faces(MeshData& mesh, const std::vector<FannedFace>& faces) {
  UncutFaces uncut;
  Cutter cutter;
  std::vector<std::uint32_t> triangles;
  for (const FannedFace& face : faces) {
    if (face.triangles == 2 && is_plainly_convex(mesh, mesh.faces.data() + 3 * face.first)) continue;
    if (!cutter.take(mesh, face) || cutter.is_convex()) continue;
    if (cutter.cut(triangles)) {
      const std::span<const std::uint32_t> corners = cutter.corners();
      std::uint32_t* const fan = mesh.faces.data() + 3 * face.first;
      std::transform(triangles.begin(), triangles.end(), fan, [&](std::uint32_t i) { return corners[i]; });
    } else if (uncut.count++ == 0) {
      uncut.first_place = face.place;
    }
  }
  return uncut;
}

}  // namespace equaltime
