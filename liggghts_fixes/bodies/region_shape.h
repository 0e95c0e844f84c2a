// A LIGGGHTS region as a body: solid is where it matches. Nothing but Region::match is asked, which is right for every
// style; LIGGGHTS' own distances from a region's surface are not (the ends of a cone along y, the outside of a wedge).
#pragma once

#include "cfd/bodies/solid_shape.h"

namespace LAMMPS_NS {
class Region;
}

namespace twogrid {

class RegionShape : public SolidShape {
 public:
  /// The region must be there as long as anything is asked, and stay as it is.
  explicit RegionShape(LAMMPS_NS::Region& region) : region_(region) {}

  /// Features thinner than a quarter of the length may be missed.
  double first_crossing(const Vec3& x, int d, double length) const override;
  /// Right to round-off where the surface is smooth or flat, to 1e-4 at edges.
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  Side side(const Vec3& x) const override { return solid(x) ? Side::kSolid : Side::kFluid; }
  void bounds(Vec3& lo, Vec3& hi) const override;

 private:
  bool solid(const Vec3& x) const;
  double first_change(const Vec3& x, const Vec3& direction, double from, double to, int samples) const;
  bool normal_at(const Vec3& x, const Vec3& direction, double t, double step, Vec3& normal) const;

  LAMMPS_NS::Region& region_;
};

}  // namespace twogrid
