// Forces of the fluid on the bodies in its grid, by what the fluid loses to them, so that fluid, bodies and sides of the
// domain together keep momentum to the last bits:
//   friction    of the pieces of the surfaces (open_shares.h), and the stress that faces beside them go without
//               (momentum/cut_links.h)
//   pressure    p A (s_below - s_above) of a cell, for each direction; s: theta_f of a solved face, 0 of a closed one, the
//               open share of a side's; and what an imposed mean gradient G gives to the open halves of cells beside
//               closed faces, which no face's momentum has: -G times their volume
//   convection  momentum carried to closed faces and slivers, which have no convection of their own, and the drag that
//               slivers have instead
// The pressure is the dynamic one: hydrostatic buoyancy, and that of G (-G times the body's volume), are not in it.
// Torque: friction at the pieces, and at the surface's points nearest to slivers and to faces whose links exceed; pressure
// on the surface's cells; G's at the points nearest to closed faces.
#pragma once

#include <array>
#include <vector>

#include "cfd/bodies/body_force.h"
#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/grid/property.h"
#include "cfd/momentum/cut_links.h"

namespace twogrid {

class BodyForces {
 public:
  /// Collective. cut: null where nothing is.
  BodyForces(const FluidDomain& domain, const CutLinks* cut);

  bool any() const { return !force_.empty(); }
  /// Of the interval that begins.
  void begin();
  /// Forces on faces, in the order of a list of them (N).
  using Lost = std::array<std::vector<double>, 3>;
  /// Adds a step's share of the interval: the state is the step's, its p what the fluid felt; convection: to the faces of
  /// OpenShares::without_convection; stress: what those of CutLinks::faces go without, and exceeding, the part of it that is
  /// the wall's; drag: coefficients of the faces without convection, per inertia share (kg/(m3 s)); pull: what drags
  /// these along against friction and drag.
  void add(double share, const FluidState& state, const Property& mu, const Lost& convection, const Lost& stress,
           const Lost& exceeding, const Lost& drag, const Lost& pull);
  /// The same of what the bodies blow (domain's blowing), which must be there.
  void add_blown(double share, double rho);
  /// Walls' velocities have changed (OpenShares::set_blowing).
  void renew_walls();
  /// Sums over ranks. Collective.
  void end();
  /// Means over the last interval, the same on all ranks.
  const std::vector<BodyForce>& forces() const { return force_; }
  /// Those of another interval, as forces() gave them.
  void restore(const std::vector<BodyForce>& forces) { force_ = forces; }

 private:
  struct Piece {
    std::ptrdiff_t face;
    int body;
    double conductance;  // over theta_f (m)
    double velocity;     // of the wall (m/s)
    double above;        // share of the upper cell in its viscosity
    Vec3 arm;            // from the body's centre (m)
    int piece;           // in the list of them
  };
  struct Pressed {
    std::ptrdiff_t cell;
    int body;
    Vec3 area;  // A (s_below - s_above) (m2)
  };
  struct Wall {
    std::ptrdiff_t cell;
    int body;
    Vec3 turning;  // arm x area into the body (m3)
  };
  /// Open halves of cells beside closed faces normal to x, y, z; of one body.
  struct Halves {
    Vec3 volume{0, 0, 0};       // m3
    std::array<Vec3, 3> arm{};  // sums of volume times arm from the body's centre (m4)
  };
  void find_centres(const OpenShares& open);
  void list_cells(const OpenShares& open);
  void find_walls(const OpenShares& open);
  void add_halves(const OpenShares& open);
  int body_near(int component, const Int3& x, Vec3* point = nullptr) const;
  /// A body that has what a face of a list loses, and the arm of that force from the body's centre (m).
  struct Nearest {
    int body;
    Vec3 arm;
  };
  std::vector<Nearest> bodies_near(int c, const std::vector<std::ptrdiff_t>& faces) const;
  void add_friction(const Nearest& to, int c, double F);

  const FluidDomain& domain_;
  CellField<FineGrid> body_;  // of the surface in a cell; -1: none. Only while the lists are made, as wall_
  std::array<CellField<FineGrid>, 3> wall_;                    // a point of it
  std::array<std::vector<double>, 3> volume_, wall_velocity_;  // of without_convection's faces (m3, m/s)
  std::array<std::vector<Piece>, 3> pieces_;                   // by component
  std::vector<Pressed> pressed_;
  std::vector<Wall> walls_;
  std::vector<Halves> halves_;  // by body; the rank's own cells'
  std::array<std::vector<Nearest>, 3> convection_to_, stress_to_;
  std::vector<BodyForce> force_;
};

}  // namespace twogrid
