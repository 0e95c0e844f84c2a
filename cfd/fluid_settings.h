// What a user chooses about the fluid. Plain values; checked by check() before anything is allocated.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/box.h"
#include "cfd/grid/grid.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

/// Sides of the fluid's domain, in the order xlo xhi ylo yhi zlo zhi.
enum Side { kXlo, kXhi, kYlo, kYhi, kZlo, kZhi };
inline int direction(int side) {
  return side / 2;
}
inline bool is_high(int side) {
  return side % 2 == 1;
}
extern const std::array<const char*, 6> kSideNames;

enum class BoundaryKind { kSlip, kNoSlip, kInlet, kPressure, kPeriodic };

/// How an inlet's velocity varies over its patch. parabolic: the mean over the patch is the given velocity; zero at the
/// patch's edges in the chosen tangential directions. table: factor interpolated linearly in one tangential coordinate.
struct InletProfile {
  enum class Shape { kConstant, kParabolic, kTable } shape = Shape::kConstant;
  std::array<bool, 3> across{false, false, false};  ///< parabolic: directions in which it varies
  int coordinate = 0;                               ///< table: direction of its first column
  std::vector<std::array<double, 2>> table;         ///< coordinate (m), factor on the velocity
};

/// What has been found of a region on its side (boundary/region_outline.h).
struct RegionOutline {
  bool found = false;              ///< a point of it
  std::array<double, 4> extent{};  ///< lo hi lo hi in the side's two directions (m)
  double area = 0;                 ///< m2
};

/// Where on a side a condition holds. Coordinates are those of the simulation box, in the side's two tangential
/// directions in ascending order (x y on z sides, x z on y sides, y z on x sides).
struct PatchShape {
  enum class Kind { kWhole, kRectangle, kCircle, kRegion } kind = Kind::kWhole;
  std::array<double, 4> value{0, 0, 0, 0};   ///< rectangle: lo, hi, lo, hi; circle: centre, centre, radius
  std::function<bool(const Vec3&)> inside;   ///< region: tells whether a face centre belongs
  std::vector<std::array<double, 6>> boxes;  ///< region: it lies within these (m); none: anywhere
  std::optional<RegionOutline> outline;      ///< region: once it has been measured
};

struct BoundaryCondition {
  std::string name;  ///< of the patch; empty for the whole side
  BoundaryKind kind = BoundaryKind::kSlip;
  PatchShape shape;
  Vec3 velocity{0, 0, 0};              ///< inlet: superficial velocity (m/s); no-slip: velocity of the wall
  std::function<Vec3()> velocity_now;  ///< if set, gives the velocity at each fluid step (a LIGGGHTS variable)
  InletProfile profile;
  double pressure = 0;  ///< pressure outlet: dynamic pressure (Pa)
};

enum class Convection { kNone, kVanLeer, kCentral };
enum class Choice { kOff, kOn, kAuto };

struct FluidSettings {
  double density = 0;                                  ///< rho_f, kg/m3
  double viscosity = 0;                                ///< mu, Pa s
  std::array<std::vector<BoundaryCondition>, 6> side;  ///< first entry: the whole side; then patches, later ones on top
  Vec3 initial_velocity{0, 0, 0};                      ///< u, interstitial, m/s
  double initial_vortex = 0;        ///< Taylor-Green vortices in x and y on top of it: amplitude, m/s
  Vec3 pressure_gradient{0, 0, 0};  ///< imposed mean dp/dx in periodic directions, Pa/m (positive: pushes to lo)
  std::array<bool, 3> flow_rate_set{false, false, false};
  Vec3 flow_rate{0, 0, 0};  ///< wanted mean of (eps u + eps_s v) in periodic directions, m/s
  double cfl = 0.4;         ///< largest Courant number of a fluid step
  double dt = 0;            ///< largest fluid step (s); 0: as cfl and the coupling interval allow
  Convection convection = Convection::kVanLeer;
  Choice implicit_viscosity = Choice::kAuto;
  bool gap_friction = false;       ///< one-cell-deep scenes: -12 mu u / W^2
  std::vector<Body> bodies;        ///< vessels and bodies inside the grid (bodies/cut_grid.h)
  std::vector<Vec3> fluid_at;      ///< points that the fluid holds, where no inlet or outlet tells
  std::vector<Vec3> particles_at;  ///< where particles lie: asked where parts on both sides reach inlets or outlets
  bool wall_stress = false;        ///< stress on the bodies' surfaces is wanted (bodies/wall_stress.h)
  OpenSpaceModel open_space;       ///< in place of bodies: shares as given (tests)
  double pressure_rtol = 1e-6;     ///< continuity error wanted, relative to U/h; also -fluid_pressure_rtol
  /// Central convection damps nothing: extrapolated in time it grows above a Courant number of 0.67 (in theory;
  /// tests/verification/test_central.cpp measures 0.60 to 0.65).
  static double largest_cfl(Convection c) { return c == Convection::kCentral ? 0.6 : 1.0; }
  /// Both throw std::invalid_argument with a sentence (value found, value wanted, keyword) when something can't be
  /// right. check: numbers, kinds of conditions, shapes on their sides; regions needn't be known yet. check_flow: every
  /// patch covers a face, and what flows in can flow out; by the velocities of now.
  void check(const FineGrid& grid) const;
  void check_flow(const FineGrid& grid) const;
};

}  // namespace twogrid
