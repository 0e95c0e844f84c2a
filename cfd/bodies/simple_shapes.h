// Surfaces with formulas: planes, cylinders, spheres. Where they are told which side the fluid is on, side() says so.
#pragma once

#include "cfd/bodies/solid_shape.h"

namespace twogrid {

enum class FluidIs { kUnknown, kInside, kOutside };

/// normal: into the fluid, of any length. knows_sides: false leaves the choice to the labels.
class PlaneShape : public SolidShape {
 public:
  PlaneShape(const Vec3& point, const Vec3& normal, bool knows_sides = true);
  double first_crossing(const Vec3& x, int d, double length) const override;
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  Side side(const Vec3& x) const override;

 private:
  double height(const Vec3& x) const;

  Vec3 point_, normal_;
  bool knows_;
};

/// Without ends. axis: of any direction and length.
class CylinderShape : public SolidShape {
 public:
  CylinderShape(const Vec3& point, const Vec3& axis, double radius, FluidIs fluid = FluidIs::kUnknown);
  double first_crossing(const Vec3& x, int d, double length) const override;
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  Side side(const Vec3& x) const override;
  void bounds(Vec3& lo, Vec3& hi) const override;

 private:
  Vec3 from_axis(const Vec3& x) const;

  Vec3 point_, axis_;
  double radius_;
  FluidIs fluid_;
};

class SphereShape : public SolidShape {
 public:
  SphereShape(const Vec3& centre, double radius, FluidIs fluid = FluidIs::kUnknown);
  double first_crossing(const Vec3& x, int d, double length) const override;
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  Side side(const Vec3& x) const override;
  void bounds(Vec3& lo, Vec3& hi) const override;

 private:
  Vec3 centre_;
  double radius_;
  FluidIs fluid_;
};

}  // namespace twogrid
