#include "cfd/bodies/simple_shapes.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace twogrid {

namespace {

double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 minus(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
/// a + s b
Vec3 along(const Vec3& a, double s, const Vec3& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
Vec3 unit(const Vec3& a, const char* what) {
  const double size = std::sqrt(dot(a, a));
  if (!(size > 0 && std::isfinite(size))) throw std::invalid_argument(std::string(what) + " needs a direction");
  return {a[0] / size, a[1] / size, a[2] / size};
}
double positive(double radius, const char* what) {
  if (!(radius > 0 && std::isfinite(radius)))
    throw std::invalid_argument(std::string(what) + " needs a radius above 0");
  return radius;
}

/// Smallest root of a s^2 + 2 b s + c = 0 in [0, 1]; kNone without one. Two roots closer than kTouch are a touch, which
/// parts nothing.
double first_root(double a, double b, double c) {
  constexpr double kTouch = 1e-6;
  const double under = b * b - a * c;
  if (!(a > 0) || !(under > 0.25 * kTouch * kTouch * a * a)) return SolidShape::kNone;
  const double q = b > 0 ? -b - std::sqrt(under) : -b + std::sqrt(under);
  double near = q / a, far = q != 0 ? c / q : near;
  if (near > far) std::swap(near, far);
  if (near >= 0 && near <= 1) return near;
  return far >= 0 && far <= 1 ? far : SolidShape::kNone;
}

SolidShape::Side side_of(bool inside, FluidIs fluid) {
  if (fluid == FluidIs::kUnknown) return SolidShape::Side::kUnknown;
  return inside == (fluid == FluidIs::kInside) ? SolidShape::Side::kFluid : SolidShape::Side::kSolid;
}

/// A direction across `axis`.
Vec3 across(const Vec3& axis) {
  int least = 0;
  for (int d = 1; d < 3; ++d)
    if (std::abs(axis[d]) < std::abs(axis[least])) least = d;
  Vec3 e{0, 0, 0};
  e[least] = 1;
  return unit(along(e, -axis[least], axis), "a cylinder");
}

}  // namespace

PlaneShape::PlaneShape(const Vec3& point, const Vec3& normal, bool knows_sides)
    : point_(point), normal_(unit(normal, "a plane")), knows_(knows_sides) {}

double PlaneShape::height(const Vec3& x) const {
  return dot(minus(x, point_), normal_);
}

double PlaneShape::first_crossing(const Vec3& x, int d, double length) const {
  const double rise = normal_[d] * length, begin = height(x);
  if (rise == 0 || begin * (begin + rise) > 0) return kNone;
  const double s = -begin / rise;
  return s >= 0 && s <= 1 ? s : kNone;
}

double PlaneShape::distance(const Vec3& x, double, Vec3& nearest) const {
  const double h = height(x);
  nearest = along(x, -h, normal_);
  return std::abs(h);
}

SolidShape::Side PlaneShape::side(const Vec3& x) const {
  return knows_ ? side_of(height(x) > 0, FluidIs::kInside) : Side::kUnknown;
}

CylinderShape::CylinderShape(const Vec3& point, const Vec3& axis, double radius, FluidIs fluid)
    : point_(point), axis_(unit(axis, "a cylinder")), radius_(positive(radius, "a cylinder")), fluid_(fluid) {}

Vec3 CylinderShape::from_axis(const Vec3& x) const {
  const Vec3 r = minus(x, point_);
  return along(r, -dot(r, axis_), axis_);
}

double CylinderShape::first_crossing(const Vec3& x, int d, double length) const {
  Vec3 way{0, 0, 0};
  way[d] = length;
  way = along(way, -length * axis_[d], axis_);
  const Vec3 r = from_axis(x);
  return first_root(dot(way, way), dot(r, way), dot(r, r) - radius_ * radius_);
}

double CylinderShape::distance(const Vec3& x, double, Vec3& nearest) const {
  Vec3 r = from_axis(x);
  const double size = std::sqrt(dot(r, r));
  if (size > 0)
    nearest = along(x, radius_ / size - 1, r);
  else
    nearest = along(x, radius_, across(axis_));
  return std::abs(size - radius_);
}

SolidShape::Side CylinderShape::side(const Vec3& x) const {
  const Vec3 r = from_axis(x);
  return side_of(dot(r, r) < radius_ * radius_, fluid_);
}

void CylinderShape::bounds(Vec3& lo, Vec3& hi) const {
  for (int d = 0; d < 3; ++d) {
    const double reach = axis_[d] == 0 ? radius_ : std::numeric_limits<double>::infinity();
    lo[d] = point_[d] - reach, hi[d] = point_[d] + reach;
  }
}

SphereShape::SphereShape(const Vec3& centre, double radius, FluidIs fluid)
    : centre_(centre), radius_(positive(radius, "a sphere")), fluid_(fluid) {}

double SphereShape::first_crossing(const Vec3& x, int d, double length) const {
  const Vec3 r = minus(x, centre_);
  return first_root(length * length, r[d] * length, dot(r, r) - radius_ * radius_);
}

double SphereShape::distance(const Vec3& x, double, Vec3& nearest) const {
  const Vec3 r = minus(x, centre_);
  const double size = std::sqrt(dot(r, r));
  nearest = size > 0 ? along(centre_, radius_ / size, r) : Vec3{centre_[0] + radius_, centre_[1], centre_[2]};
  return std::abs(size - radius_);
}

SolidShape::Side SphereShape::side(const Vec3& x) const {
  const Vec3 r = minus(x, centre_);
  return side_of(dot(r, r) < radius_ * radius_, fluid_);
}

void SphereShape::bounds(Vec3& lo, Vec3& hi) const {
  for (int d = 0; d < 3; ++d) lo[d] = centre_[d] - radius_, hi[d] = centre_[d] + radius_;
}

}  // namespace twogrid
