// A surface that bounds the fluid inside its grid: a vessel's wall, a tube, a cone. It answers what the cutting of the
// grid asks (cut_grid.h) and knows nothing of grids; which of its sides the fluid is on is found there. All ranks hold
// the whole surface.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "cfd/grid/box.h"

namespace twogrid {

class SolidShape {
 public:
  virtual ~SolidShape() = default;
  static constexpr double kNone = 2;
  /// Share of the way from x over `length` (m, of either sign) along axis d at which the surface is first met, 0 to 1;
  /// kNone where it isn't.
  virtual double first_crossing(const Vec3& x, int d, double length) const = 0;
  /// Distance of x from the surface (m), and the surface's nearest point; need be right only where it is below `reach`,
  /// and is larger than it elsewhere.
  virtual double distance(const Vec3& x, double reach, Vec3& nearest) const = 0;
  /// What the shape itself knows of a point that is not on its surface. A region knows what is solid, a mesh does not.
  enum class Side { kUnknown, kSolid, kFluid };
  virtual Side side(const Vec3&) const { return Side::kUnknown; }
  /// Corners of a box around the surface; lo > hi: not known.
  virtual void bounds(Vec3& lo, Vec3& hi) const { lo = {1, 1, 1}, hi = {0, 0, 0}; }
};

/// How a surface moves along itself while the body stays where it is, as a rigid body would: a drum about its axis, a belt.
struct SurfaceMotion {
  Vec3 velocity{0, 0, 0};  ///< m/s
  Vec3 turning{0, 0, 0};   ///< rad/s, about an axis through origin
  Vec3 origin{0, 0, 0};    ///< m
  bool any() const { return turning != Vec3{0, 0, 0} || velocity != Vec3{0, 0, 0}; }
  Vec3 at(const Vec3& x) const {
    const Vec3 r{x[0] - origin[0], x[1] - origin[1], x[2] - origin[2]};
    return {velocity[0] + turning[1] * r[2] - turning[2] * r[1], velocity[1] + turning[2] * r[0] - turning[0] * r[2],
            velocity[2] + turning[0] * r[1] - turning[1] * r[0]};
  }
};

/// Gas that a body's surface blows into the fluid, normal to itself: a sparger, a porous plate (fluid/blowing.h).
struct Blow {
  bool on = false;
  double velocity = 0;                     ///< m3/s through a m2 of the surface, at least 0
  std::function<double()> velocity_now;    ///< if set, gives the velocity at each fluid step
  std::function<bool(const Vec3&)> where;  ///< which points of the surface blow; empty: all
};

/// One body as the user names it.
struct Body {
  std::string name;
  std::shared_ptr<const SolidShape> shape;
  bool slip = false;
  bool sheet = false;  ///< fluid on both sides (sheets.h)
  SurfaceMotion motion = {};
  Blow blow = {};
};

}  // namespace twogrid
