// Gas that bodies blow into the fluid through their surface, each with one velocity U normal to it, a number or a function of
// time. With A the area of the surface in a cut cell and n its normal into the fluid:
//   continuity  U A of a cell, of fluid alone (eps = 1), whatever the void fraction before the wall
//   momentum    rho U A (U n + the surface's own motion), half to each of the cell's two faces of a component; what would
//               go to a closed face the body has; slivers, which have no convection, are held to what they follow by a drag
//               of the strength of what comes in (momentum carried in with that velocity, and out with their own)
// What the fluid has at such a wall is U n in place of 0: friction, links and what slivers follow (bodies/wall_links.h,
// OpenShares::set_blowing), and what convection carries past closed faces (momentum/convection.h). Where nothing blows
// there is no such object.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/field.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

struct FluidDomain;

class Blowing {
 public:
  /// Collective. The bodies must outlive this; they may change their velocities. Throws std::invalid_argument with a
  /// sentence where a body that is to blow has no surface in the fluid that does.
  Blowing(const FluidDomain& domain, const std::vector<Body>& bodies, const std::vector<OpenSpace::BlownCell>& cells);

  /// Takes the bodies' velocities of now. True if one has changed, and at the first call. Same on all ranks. Collective.
  bool update(const FluidDomain& domain);
  /// Of each body (m/s); 0 of those that don't blow.
  const std::vector<double>& velocity() const { return velocity_; }
  /// Of each body, as resolved, all ranks (m2).
  const std::vector<double>& area() const { return area_; }
  /// Volume that comes into own cells (m3/s).
  double own_flow() const;

  /// out += what comes in brings to own solved faces, N.
  void add_momentum(double rho, FaceField<FineGrid>& out) const;
  /// Takes what comes in off the imbalance of own cells (m3/s), and off its sum; largest: at least each U (m/s).
  void take_off(CellField<FineGrid>& imbalance, double& sum, double& largest) const;
  /// Volume that comes into a cell, over the cell's, 1/s; own cells and halo.
  const CellField<FineGrid>& rate() const { return rate_; }
  /// Sum over own cells of the area that blows, and of the pressure at it, by the gradient before it, times the area.
  void add_pressure(const CellField<FineGrid>& p, double& of_pressure, double& of_area) const;
  /// f(body, momentum that comes in (N), that part of it which the body has for want of faces); own cells, sums over the
  /// bodies' surfaces.
  template <class F>
  void for_each_body(double rho, F&& f) const {
    for (std::size_t b = 0; b < sums_.size(); ++b)
      if (bodies_[b].blow.on) f(b, force(rho, velocity_[b], sums_[b].all), force(rho, velocity_[b], sums_[b].kept));
  }

 private:
  struct Cell {
    std::ptrdiff_t at;  // memory index of fields with halo
    Int3 cell;
    int body;
    double size, volume;  // of the surface (m2), of the cell (m3)
    // The pressure at the surface: that of the cell, and shares of the change to the next cells before it.
    std::array<std::ptrdiff_t, 3> next;
    Vec3 share;
  };
  void find_next(const FluidDomain& domain, const WallCell& wall, Cell& cell) const;
  /// Of a surface or of a face's share of it: m2, and m3/s.
  struct Push {
    double square = 0, linear = 0;
    double at(double rho, double U) const { return rho * U * (U * square + linear); }
  };
  struct OfFace {
    std::ptrdiff_t face;
    int body;
    Push push;
  };
  struct Sums {
    std::array<Push, 3> all, kept;
  };
  static Vec3 force(double rho, double U, const std::array<Push, 3>& push) {
    return {push[0].at(rho, U), push[1].at(rho, U), push[2].at(rho, U)};
  }

  const std::vector<Body>& bodies_;
  std::vector<double> velocity_, area_;
  std::vector<Cell> cells_;
  std::array<std::vector<OfFace>, 3> faces_;
  std::vector<Sums> sums_;  // of each body, own cells
  CellField<FineGrid> rate_;
  bool known_ = false;
};

}  // namespace twogrid
