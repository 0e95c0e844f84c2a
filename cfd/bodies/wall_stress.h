// What the fluid does to the bodies' surfaces, place by place, as measured from the velocities and pressures before them:
//
//   friction  mu eps d(u_t)/dn at the wall: each component of the velocity, less the wall's, as
//             phi (a0 + linear and quadratic terms in phi and along the wall), phi the distance from the wall, by weighted
//             least squares through the velocities of open faces within some two cells
//   pressure  a polynomial of second degree through the pressures of open cells within three
//
// from places that no wall parts from the facet. The weights are found once; a facet's value then is a sum over some
// tens of numbers, whatever the facet's area. The forces on bodies (body_forces.h) are those of the momentum balance: the
// sum over facets differs from them by the errors of the fits.
#pragma once

#include <array>
#include <vector>

#include "cfd/bodies/surfaces.h"
#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/grid/property.h"

namespace twogrid {

/// The surface in one cell.
struct WallFacet {
  int body = 0;
  Int3 cell{0, 0, 0};         ///< own
  double area = 0;            ///< m2
  Vec3 normal{0, 0, 0};       ///< into the fluid
  Vec3 centre{0, 0, 0};       ///< m
  std::vector<Vec3> corners;  ///< a closed line around it (m)
};

class WallStress {
 public:
  /// The open shares must have outlines. All must outlive this; state and viscosity are those of the present.
  WallStress(const FluidDomain& domain, const std::vector<Body>& bodies, const FluidState& state,
             const Property& viscosity);

  /// Velocities of walls that blow have changed (OpenShares::set_blowing): that of each body.
  void renew_walls(const std::vector<double>& velocity);
  const std::vector<WallFacet>& facets() const { return facets_; }
  /// On the body, N/m2.
  Vec3 friction(std::size_t facet) const;
  /// Dynamic, at the wall, Pa: of the field last taken. Collective.
  void take() { take(state_.p); }
  void take(const CellField<FineGrid>& p);
  double pressure(std::size_t facet) const { return pressure_.sum(facet, p_.data()); }
  /// Derivative of a velocity, with halo, along the normal, at the wall, 1/s.
  Vec3 slope(std::size_t facet, const FaceField<FineGrid>& u) const;
  /// Sums over the facets of each body, force (N): friction, pressure. Collective.
  std::vector<std::array<Vec3, 2>> sums() const;

 private:
  struct Weight {
    std::ptrdiff_t at;  // memory index
    double weight;
  };
  struct Weights {
    std::vector<Weight> list;
    std::vector<std::size_t> begin{0};  // of each facet
    double sum(std::size_t facet, const double* values) const {
      double s = 0;
      for (std::size_t q = begin[facet]; q < begin[facet + 1]; ++q) s += list[q].weight * values[list[q].at];
      return s;
    }
  };
  /// Where a facet's fits are made: its nearest place on the true surface, and lengths of the cell.
  struct Place {
    Int3 cell;
    Vec3 point, normal, width;
    double across;              // a cell's width along the normal
    std::array<Vec3, 2> along;  // over the cell's widths
  };
  void list_facets(const std::vector<Body>& bodies);
  class Feet;
  Place place_of(const WallFacet& facet, const Feet& feet) const;
  /// Open shares of cells and of their low faces, as far as pressures come from.
  struct Wide {
    CellField<FineGrid> theta;
    std::array<CellField<FineGrid>, 3> open;
  };
  Box around(const Int3& cell, int cells, const Box& within) const;
  void fit_friction(const Place& place, const std::vector<Int3>& cells, Feet& feet, int c);
  void fit_pressure(const Place& place, const Wide& shares, const Feet& feet);

  const FluidDomain& domain_;
  const FluidState& state_;
  const Property& viscosity_;
  std::size_t bodies_ = 0;
  std::vector<WallFacet> facets_;
  std::vector<Vec3> area_;     // vectors of area, into the fluid
  std::vector<char> slip_;     // of facets
  std::vector<Vec3> normal_;   // of the surface itself
  std::vector<Vec3> of_wall_;  // what the wall's own velocity takes from the slope, 1/s
  /// What of_wall_ is made of, where some body blows.
  struct OfWall {
    std::size_t facet;
    int component, body;
    std::ptrdiff_t face;
    double weight, at_rest, share;  // 1/m; wall's velocity of its motion (m/s); share of the body's velocity in it
  };
  std::vector<OfWall> blown_;
  std::array<Weights, 3> slope_;
  Weights pressure_;
  BlockExchange wide_;
  CellField<FineGrid> p_;  // own cells and those that pressures come from
};

}  // namespace twogrid
