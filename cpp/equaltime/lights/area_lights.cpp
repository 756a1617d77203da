#include "equaltime/lights/area_lights.h"

#include <algorithm>
#include <cmath>

#include "equaltime/math/elementary.h"
#include "equaltime/math/frame.h"
#include "equaltime/sampling/warps.h"
#include "equaltime/shapes/triangle_plane.h"

namespace equaltime {

namespace {

/// Below this solid angle the sampling of a spherical polygon has lost digits that float64 cannot spare.
constexpr double kSmallestView = 1e-8;

float area_pdf(Vec3f receiver, Vec3f wi, Vec3f point, const Vec3f& normal, float area) noexcept {
  const float cosine = -dot(normal, wi);
  return cosine > 0 ? length_squared(point - receiver) / (cosine * area) : 0.0F;
}

double emitted_power(const Spectrum& radiance, double area) noexcept {
  return std::numbers::pi * area * static_cast<double>(radiance.mean());
}

/// Of a flat light: the middle of the box that holds it, and how far its corners are from there.
EmitterBounds flat_bounds(std::initializer_list<Vec3d> corners, const Vec3f& normal, double power) noexcept {
  EmitterBounds bounds{{}, 0, {Vec3d(normal), 0}, power * std::numbers::inv_pi};
  for (const Vec3d& p : corners) bounds.box.include(p);
  for (const Vec3d& p : corners) bounds.radius = std::max(bounds.radius, length(p - bounds.box.center()));
  return bounds;
}

/// Where a direction meets a plane: a·edge_u + b·edge_v from the plane's origin.
struct PlanePoint {
  double a, b;
  Vec3f point;
};

/// Of a plane given by its origin and two edges; nothing if it lies behind or edge-on.
std::optional<PlanePoint> plane_towards(Vec3f receiver, Vec3f wi, const Vec3d& origin, const Vec3d& edge_u,
                                        const Vec3d& edge_v) noexcept {
  const Vec3d from(receiver), direction(wi), to_receiver = from - origin;
  const Vec3d across = cross(direction, edge_v), along = cross(to_receiver, edge_u);
  const double inverse = 1 / dot(edge_u, across), t = dot(edge_v, along) * inverse;
  if (!(t > 0 && t < kInfinity)) return std::nullopt;
  return PlanePoint{dot(to_receiver, across) * inverse, dot(direction, along) * inverse, Vec3f(from + direction * t)};
}

}  // namespace

// --- Triangle -----------------------------------------------------------------------------------------------------

TriangleLight::TriangleLight(const Vec3f& v0, const Vec3f& v1, const Vec3f& v2, const Spectrum& radiance) noexcept
    : v0_(v0),
      e1_(v1 - v0),
      e2_(v2 - v0),
      center_(v0 + (e1_ + e2_) * (1.0F / 3.0F)),
      offset_(triangle_plane(v0, v1, v2).offset),
      size_squared_(std::max(length_squared(e1_), std::max(length_squared(e2_), length_squared(v2 - v1)))),
      radiance_(radiance) {
  const Vec3d scaled_normal = cross(Vec3d(v1) - Vec3d(v0), Vec3d(v2) - Vec3d(v0));
  const double twice_area = length(scaled_normal);
  area_ = static_cast<float>(0.5 * twice_area);
  normal_ = Vec3f(scaled_normal / twice_area);
}

std::optional<SphericalTriangle> TriangleLight::near_view(Vec3f receiver) const noexcept {
  const SphericalTriangle view(Vec3d(v0_) - Vec3d(receiver), Vec3d(e1_), Vec3d(e2_));
  if (!(view.solid_angle() > kSmallestView)) return std::nullopt;
  return view;
}

ViewPoint TriangleLight::sample_view(Vec3f receiver, Point2f u, ViewPoint otherwise) const noexcept {
  const auto view = near_view(receiver);
  if (!view) return otherwise;
  return {point_in(*view, receiver, u), static_cast<float>(view->solid_angle())};
}

Vec3f TriangleLight::point_in(const View& view, Vec3f receiver, Point2f u) const noexcept {
  const Vec3d direction = view.sample(u);
  const Vec3d normal = cross(Vec3d(e1_), Vec3d(e2_)), from(receiver);
  const double t = dot(normal, Vec3d(v0_) - from) / dot(normal, direction);
  return Vec3f(from + direction * t);
}

float TriangleLight::pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept {
  if (!faces(receiver)) return 0;
  if (is_near(receiver))
    if (const auto view = near_view(receiver)) return static_cast<float>(1 / view->solid_angle());
  return area_pdf(receiver, wi, point, normal_, area_);
}

std::optional<Vec3f> TriangleLight::met(Vec3f receiver, Vec3f wi) const noexcept {
  const auto hit = plane_towards(receiver, wi, Vec3d(v0_), Vec3d(e1_), Vec3d(e2_));
  return hit && hit->a >= 0 && hit->b >= 0 && hit->a + hit->b <= 1 ? std::optional(hit->point) : std::nullopt;
}

float TriangleLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const auto point = met(receiver, wi);
  return point ? pdf(receiver, wi, *point) : 0.0F;
}

double TriangleLight::power() const noexcept { return emitted_power(radiance_, area_); }

EmitterBounds TriangleLight::bounds() const noexcept {
  const Vec3d v0(v0_);
  return flat_bounds({v0, v0 + Vec3d(e1_), v0 + Vec3d(e2_)}, normal_, power());
}

TriangleLight TriangleLight::placed(const AffineMap& to) const noexcept {
  const Vec3d v0(v0_);
  const Vec3f a(to.point(v0)), b(to.point(v0 + Vec3d(e1_))), c(to.point(v0 + Vec3d(e2_)));
  return to.mirrors() ? TriangleLight(a, c, b, radiance_) : TriangleLight(a, b, c, radiance_);
}

// --- Rectangle ----------------------------------------------------------------------------------------------------

RectangleLight::RectangleLight(const Vec3f& corner, const Vec3d& edge_x, const Vec3d& edge_y, bool flipped,
                               const Spectrum& radiance) noexcept
    : corner_(corner),
      edge_x_(edge_x),
      edge_y_(edge_y),
      normal_(normalize(cross(edge_x, edge_y)) * (flipped ? -1.0 : 1.0)),
      center_(corner + (edge_x_ + edge_y_) * 0.5F),
      area_(static_cast<float>(length(cross(edge_x, edge_y)))),
      offset_(triangle_plane(corner, corner + edge_x_, corner + edge_x_ + edge_y_).offset),
      size_squared_(length_squared(edge_x_) + length_squared(edge_y_)),
      radiance_(radiance) {}

std::optional<SphericalRectangle> RectangleLight::near_view(Vec3f receiver) const noexcept {
  const Vec3d x(edge_x_), y(edge_y_);
  const double width = length(x), height = length(y);
  const SphericalRectangle view(Vec3d(corner_) - Vec3d(receiver), x / width, y / height, width, height);
  if (!(view.solid_angle() > kSmallestView)) return std::nullopt;
  return view;
}

ViewPoint RectangleLight::sample_view(Vec3f receiver, Point2f u, ViewPoint otherwise) const noexcept {
  const auto view = near_view(receiver);
  if (!view) return otherwise;
  return {point_in(*view, receiver, u), static_cast<float>(view->solid_angle())};
}

Vec3f RectangleLight::point_in(const View& view, Vec3f receiver, Point2f u) const noexcept {
  return Vec3f(Vec3d(receiver) + view.sample(u));
}

float RectangleLight::pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept {
  if (!faces(receiver)) return 0;
  if (is_near(receiver))
    if (const auto view = near_view(receiver)) return static_cast<float>(1 / view->solid_angle());
  return area_pdf(receiver, wi, point, normal_, area_);
}

std::optional<Vec3f> RectangleLight::met(Vec3f receiver, Vec3f wi) const noexcept {
  const auto hit = plane_towards(receiver, wi, Vec3d(corner_), Vec3d(edge_x_), Vec3d(edge_y_));
  const auto within = [](double x) { return x >= 0 && x <= 1; };
  return hit && within(hit->a) && within(hit->b) ? std::optional(hit->point) : std::nullopt;
}

float RectangleLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const auto point = met(receiver, wi);
  return point ? pdf(receiver, wi, *point) : 0.0F;
}

double RectangleLight::power() const noexcept { return emitted_power(radiance_, area_); }

EmitterBounds RectangleLight::bounds() const noexcept {
  const Vec3d corner(corner_), x(edge_x_), y(edge_y_);
  return flat_bounds({corner, corner + x, corner + y, corner + x + y}, normal_, power());
}

// --- Sphere -------------------------------------------------------------------------------------------------------

namespace {

/// 1 - cosθ of the cone that a sphere fills from a distance, without cancellation however small or near it is.
double one_minus_cos_max(double distance, double radius) noexcept {
  const double inverse = 1 / distance;
  const double cos2 = (distance - radius) * inverse * ((distance + radius) * inverse);
  return square(radius * inverse) / (1 + std::sqrt(cos2));
}

}  // namespace

bool SphereLight::faces(Vec3f receiver, const Vec3d& to_center, double distance) const noexcept {
  if (!inward_) return distance > radius_;
  // A receiver on the sphere itself sees the rest of it, on whichever side its rounding may have put it.
  const Vec3f normal(to_center / std::max(distance, radius_));
  return distance <= radius_ + static_cast<double>(point_offset(receiver, normal));
}

Optional<LightSample> SphereLight::sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver);
  const double distance = length(to_center);
  if (!faces(receiver, to_center, distance)) return std::nullopt;
  Vec3d local;
  double along;  // distance to the sphere in that direction
  float pdf;
  if (inward_) {
    local = Vec3d(square_to_uniform_sphere(u));
    const double b = distance * local.z;
    along = b + std::sqrt(std::max(0.0, b * b + (radius_ - distance) * (radius_ + distance)));
    if (!(along > 0)) return std::nullopt;
    pdf = kUniformSpherePdf;
  } else {
    const double range = one_minus_cos_max(distance, radius_);
    const double one_minus_cos = static_cast<double>(u.x) * range;
    const double sin2 = one_minus_cos * (2 - one_minus_cos);
    const auto [sin_phi, cos_phi] = sin_cos_turn(u.y);  // the azimuth alone: float32 is enough
    const double sine = std::sqrt(sin2);
    local = {sine * static_cast<double>(cos_phi), sine * static_cast<double>(sin_phi), 1 - one_minus_cos};
    const double half_chord = std::sqrt(std::max(0.0, square(radius_) - square(distance) * sin2));
    along = distance * local.z - half_chord;
    pdf = static_cast<float>(1 / (2 * std::numbers::pi * range));
  }
  const FrameD frame = FrameD::from_normal(distance > 0 ? to_center * (1 / distance) : Vec3d{0, 0, 1});
  const Vec3d direction = frame.to_world(local);
  const Vec3d outward = normalize(direction * along - to_center);
  const Vec3f normal(outward * (inward_ ? -1.0 : 1.0)), point(center_ + outward * radius_);
  return LightSample{
      Vec3f(direction), radiance_, pdf * pmf, static_cast<float>(along), {point, normal, point_offset(point, normal)}};
}

float SphereLight::pdf(Vec3f receiver, Vec3f, Vec3f) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver);
  const double distance = length(to_center);
  if (!faces(receiver, to_center, distance)) return 0;
  if (inward_) return kUniformSpherePdf;
  return static_cast<float>(1 / (2 * std::numbers::pi * one_minus_cos_max(distance, radius_)));
}

float SphereLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const Vec3d to_center = center_ - Vec3d(receiver), direction(wi);
  const bool met = dot(to_center, direction) > 0 && length_squared(cross(to_center, direction)) <= square(radius_);
  return inward_ || met ? pdf(receiver, wi, {}) : 0.0F;
}

double SphereLight::power() const noexcept { return emitted_power(radiance_, 4 * std::numbers::pi * square(radius_)); }

EmitterBounds SphereLight::bounds() const noexcept {
  const Vec3d half{radius_, radius_, radius_};
  return {{center_ - half, center_ + half}, radius_, {}, power() * 0.25 * std::numbers::inv_pi};
}

SphereLight SphereLight::placed(const AffineMap& to) const noexcept {
  return {to.point(center_), radius_ * length(to.columns[0]), inward_, radiance_};
}

// --- Disk ---------------------------------------------------------------------------------------------------------

DiskLight::DiskLight(const Vec3d& center, const Vec3d& axis_u, const Vec3d& axis_v, bool flipped,
                     const Spectrum& radiance) noexcept
    : center_(center), axis_u_(axis_u), axis_v_(axis_v), radiance_(radiance) {
  const Vec3d scaled_normal = cross(axis_u, axis_v);
  area_ = static_cast<float>(std::numbers::pi * length(scaled_normal));
  normal_ = Vec3f(normalize(scaled_normal) * (flipped ? -1.0 : 1.0));
  const Vec3f furthest(abs(center) + abs(axis_u) + abs(axis_v));
  offset_ = point_offset(furthest, normal_);
}

Optional<LightSample> DiskLight::sample(Vec3f receiver, Point2f u, float pmf) const noexcept {
  const float height = height_of(receiver);
  if (!(height > offset_)) return std::nullopt;
  const Point2f d = square_to_disk(u);
  const Vec3f point(center_ + axis_u_ * static_cast<double>(d.x) + axis_v_ * static_cast<double>(d.y));
  return flat_sample(receiver, {point, normal_, offset_}, height, radiance_, area_, 0, pmf);
}

float DiskLight::pdf(Vec3f receiver, Vec3f wi, Vec3f point) const noexcept {
  if (!faces(receiver)) return 0;
  return area_pdf(receiver, wi, point, normal_, area_);
}

float DiskLight::pdf_direction(Vec3f receiver, Vec3f wi) const noexcept {
  const auto hit = plane_towards(receiver, wi, center_, axis_u_, axis_v_);
  return hit && square(hit->a) + square(hit->b) <= 1 ? pdf(receiver, wi, hit->point) : 0.0F;
}

double DiskLight::power() const noexcept { return emitted_power(radiance_, area_); }

EmitterBounds DiskLight::bounds() const noexcept {
  const Vec3d &u = axis_u_, &v = axis_v_;
  const Vec3d half{elementary::hypot(u.x, v.x), elementary::hypot(u.y, v.y), elementary::hypot(u.z, v.z)};
  const double uu = length_squared(u), vv = length_squared(v), uv = dot(u, v);
  const double longest_axis_squared = 0.5 * (uu + vv + elementary::hypot(uu - vv, 2 * uv));  // of the ellipse
  return {{center_ - half, center_ + half},
          std::sqrt(longest_axis_squared),
          {Vec3d(normal_), 0},
          power() * std::numbers::inv_pi};
}

DiskLight DiskLight::placed(const AffineMap& to) const noexcept {
  const bool flipped = dot(cross(axis_u_, axis_v_), Vec3d(normal_)) < 0;
  return {to.point(center_), to.vector(axis_u_), to.vector(axis_v_), flipped != to.mirrors(), radiance_};
}

}  // namespace equaltime
