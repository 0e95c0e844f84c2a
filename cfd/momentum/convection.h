// Convection in the momentum balance: -rho div(eps u u) on the staggered volumes (cfd/measures/grid_measures.h).
#pragma once

#include <array>
#include <vector>

#include "cfd/fluid_settings.h"
#include "cfd/grid/field.h"
#include "cfd/measures/grid_measures.h"

namespace twogrid {

class ConvectionTerm {
 public:
  /// own: the rank's cells; local: own cells and halo. faces[d]: the rank's own faces. solved[d]: false where u[d] is
  /// zero and nothing varies along d (one cell between slip walls): that component and direction are left out.
  ConvectionTerm(const FineGrid& grid, const GridMeasures& measures, const Box& own, const Box& local,
                 const std::array<Box, 3>& faces, const std::array<bool, 3>& solved);

  /// out -= rho sum over the volume's faces of (F u), N, F = eps_f u, both with halo and ghosts. van Leer (1974)
  /// limited, or central. Along its own direction only the part of a change of u that doesn't keep eps_f u constant is
  /// limited.
  void add(double rho, const FaceField<FineGrid>& eps_f, const FaceField<FineGrid>& u, Convection scheme,
           FaceField<FineGrid>& out);
  /// Walls' velocities have changed (OpenShares::set_blowing).
  void renew_walls(const OpenShares& open);
  /// rho F u of component c through the centre of own cell (i,j,k), along c, as add() takes it, N.
  double convected_through(int c, int i, int j, int k, double rho, const FaceField<FineGrid>& eps_f,
                           const FaceField<FineGrid>& u, Convection scheme) const;

 private:
  struct Convected;  // what is convected, and by what
  template <int c, int d, bool limited, bool cut>
  void side_row(const Convected& a, int i, int j, int k, int count, double* q) const;
  template <int c, bool limited, bool whole, bool cut>
  void convect_component(const Convected& a, Array3<double>& out);
  void convect_limited(const Convected& a, FaceField<FineGrid>& out);
  void convect_central(const Convected& a, FaceField<FineGrid>& out);
  void convect_limited_between_bodies(const Convected& a, FaceField<FineGrid>& out);
  void convect_central_between_bodies(const Convected& a, FaceField<FineGrid>& out);
  void list_cut_sides(const OpenShares& open);
  void convect_limited_beside_links(const Convected& a, FaceField<FineGrid>& out);
  void list_moving_side(const OpenShares& open, int c, int d, const Int3& upper, std::ptrdiff_t m);
  void carry_walls(const Convected& a, FaceField<FineGrid>& out) const;

  OpenRows::Part part(int c, int j, int k) const;

  Box own_, local_;
  std::array<Box, 3> faces_;
  std::array<const OpenRows*, 3> rows_;  // parts of the faces' rows; null: whole rows
  std::array<bool, 3> solved_;
  std::array<AxisMeasure, 3> axis_;
  std::array<bool, 3> periodic_;
  Int3 n_;
  /// Bits of faces: the limiter of the side below in d of a volume of component c would look at a wall, where the flow
  /// goes up or down. Of size 0: nowhere.
  static constexpr long long central_if(int c, int d, bool up) { return 1LL << (2 * (3 * c + d) + (up ? 0 : 1)); }
  Array3<long long> central_;
  /// A side between an open and a closed face, whose velocity is that of a wall that moves along itself.
  struct MovingSide {
    std::ptrdiff_t upper, other;  // faces: of the component; the second that carries through the side
    double here, there;           // areas that the two carry through, times the wall's share of the velocity (m3/s)
    std::ptrdiff_t closed;        // the closed face
    double part;                  // both over the wall's velocity and the lengths of the next two (m or m2)
    double half_here, half_there;
    void move(double velocity) { here = half_here * (part * velocity), there = half_there * (part * velocity); }
  };
  std::array<std::array<std::vector<MovingSide>, 3>, 3> moving_sides_;
  std::array<std::vector<double>, 3> side_;  // scratch: fluxes through the sides of a row, two rows, two slabs
};

}  // namespace twogrid
