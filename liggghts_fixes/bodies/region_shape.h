// A LIGGGHTS region as a body: solid is where it matches. Nothing but Region::match is asked, which is right for every
// style; LIGGGHTS' own distances from a region's surface are not (the ends of a cone along y, the outside of a wedge).
// A region that ends in the plane of a side of the domain has no surface there: beyond a periodic side lies what is at the
// other one (regions that stick out of one of the two have images, surfaces.h), beyond others what is at the side.
#pragma once

#include <array>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/grid.h"

namespace LAMMPS_NS {
class Region;
}

namespace twogrid {

class RegionShape : public SolidShape {
 public:
  /// The region must be there as long as anything is asked, and stay as it is.
  RegionShape(LAMMPS_NS::Region& region, const FineGrid& grid);

  /// Features thinner than a quarter of the length may be missed.
  double first_crossing(const Vec3& x, int d, double length) const override;
  /// Right to round-off where the surface is smooth or flat, to 1e-4 at edges.
  double distance(const Vec3& x, double reach, Vec3& nearest) const override;
  Side side(const Vec3& x) const override { return solid(x) ? Side::kSolid : Side::kFluid; }
  void bounds(Vec3& lo, Vec3& hi) const override;

 private:
  bool solid(const Vec3& x) const;
  bool ends_at(int d, double plane, double inwards, const FineGrid& grid) const;
  double first_change(const Vec3& x, const Vec3& direction, double from, double to, int samples) const;
  bool normal_at(const Vec3& x, const Vec3& direction, double t, double step, Vec3& normal) const;

  LAMMPS_NS::Region& region_;
  struct Sides {
    double lo, hi, inwards;
    bool wraps;                // beyond lies what is at the other one
    bool ends_low, ends_high;  // the region ends in the plane: beyond lies what is at the side
  };
  std::array<Sides, 3> sides_;
};

}  // namespace twogrid
