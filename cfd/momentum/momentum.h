// The terms of the momentum balance on the staggered volumes of a tensor-product grid. The volume of face f normal to c
// reaches from the centre of cell f-1 to that of cell f; at a pressure outlet only the half inside the domain counts.
#pragma once

#include <array>
#include <vector>

#include "cfd/fluid_settings.h"
#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"

namespace twogrid {

/// One-dimensional measures of an axis, by index, including the halo.
struct AxisMeasure {
  int lo = 0;
  std::vector<double> width_, face_width_, half_below_, half_above_;
  std::vector<double> inverse_width_, inverse_face_width_;        // 1/m
  std::vector<double> above_share_;                               // of cell i in the mean of cells i-1 and i
  double width(int i) const { return width_[i - lo]; }            ///< of cell i, m
  double face_width(int i) const { return face_width_[i - lo]; }  ///< between centres of cells i-1 and i, m
  double half_below(int i) const { return half_below_[i - lo]; }  ///< part of face i's volume in cell i-1 (0 outside)
  double half_above(int i) const { return half_above_[i - lo]; }  ///< part of face i's volume in cell i (0 outside)
};

class Momentum {
 public:
  /// own: the rank's cells; local: own cells and halo. faces[d]: the rank's own faces. solved[d]: false where u[d] is
  /// zero and nothing varies along d (one cell between slip walls): that component and direction are left out.
  Momentum(const FineGrid& grid, const Box& own, const Box& local, const std::array<Box, 3>& faces,
           const std::array<bool, 3>& solved);

  /// eps on faces: volume-weighted arithmetic mean of the two cells, so that sums over cells and faces agree.
  void face_mean(const CellField<FineGrid>& eps, FaceField<FineGrid>& eps_f) const;
  /// The same for one own face of direction c.
  double face_mean(const CellField<FineGrid>& eps, int c, int i, int j, int k) const {
    const std::ptrdiff_t m = eps.index(i, j, k);
    const double below = eps.data()[m - eps.stride(c)];
    return below + axis_[c].above_share_[Int3{i, j, k}[c] - axis_[c].lo] * (eps.data()[m] - below);
  }
  /// out -= rho sum over the volume's faces of (F u), N, F = eps_f u, both with halo and ghosts. van Leer (1974)
  /// limited, or central. Along its own direction only the part of a change of u that doesn't keep eps_f u constant is
  /// limited.
  void convect(double rho, const FaceField<FineGrid>& eps_f, const FaceField<FineGrid>& u, Convection scheme,
               FaceField<FineGrid>& out);
  /// rho F u of component c through the centre of own cell (i,j,k), along c, as convect takes it, N.
  double convected_through(int c, int i, int j, int k, double rho, const FaceField<FineGrid>& eps_f,
                           const FaceField<FineGrid>& u, Convection scheme) const;
  /// out += integral of div(eps tau), tau = mu (grad u + grad u^T - 2/3 div u I), N.
  void viscous(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, FaceField<FineGrid>& out);
  /// Diagonal of -viscous, approximately (for Jacobi), N s/m.
  void viscous_diagonal(double mu, const CellField<FineGrid>& eps, FaceField<FineGrid>& diagonal) const;
  /// Volume of face (i,j,k) normal to c, m3.
  double volume(int c, int i, int j, int k) const {
    const Int3 q{i, j, k};
    const int e = (c + 1) % 3, f = (c + 2) % 3;
    return (axis_[c].half_below(q[c]) + axis_[c].half_above(q[c])) * axis_[e].width(q[e]) * axis_[f].width(q[f]);
  }
  const AxisMeasure& axis(int d) const { return axis_[d]; }

 private:
  struct Convected;  // what is convected, and by what
  template <int c, int d, bool limited>
  void side_row(const Convected& a, int i, int j, int k, int count, double* q) const;
  template <int c, bool limited>
  void convect_component(const Convected& a, Array3<double>& out);
  void convect_limited(const Convected& a, FaceField<FineGrid>& out);
  void convect_central(const Convected& a, FaceField<FineGrid>& out);
  using Slab = std::vector<double>;
  void normal_stresses(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k);
  template <int t>
  void shear_stress(double mu, const CellField<FineGrid>& eps, const FaceField<FineGrid>& u, int k, Slab& out) const;
  template <int c>
  void add_stress(int k, Array3<double>& out) const;

  Box own_, local_;
  std::array<Box, 3> faces_;
  std::array<bool, 3> solved_;
  std::array<AxisMeasure, 3> axis_;
  std::array<bool, 3> periodic_;
  Int3 n_;
  std::array<std::vector<double>, 3> side_;  // scratch: fluxes through the sides of a row, two rows, two slabs
  // Scratch of viscous(), slabs at one z: eps tau_cc in cells (of tau_zz also the slab below), eps tau_yz, tau_xz,
  // tau_xy on edges (of the first two also the slab above). Where a direction is left out there is no shear with it:
  // zero.
  std::array<Slab, 3> normal_, shear_;
  Slab normal_below_;
  std::array<Slab, 2> shear_above_;
};

}  // namespace twogrid
