// div( c grad phi ) = b on the fine grid: conjugate gradients (PETSc KSP, options prefix -fluid_pressure_)
// preconditioned by a geometric multigrid that semi-coarsens, so that thin, stretched and odd-sized grids converge
// alike.
#pragma once

#include <mpi.h>

#include <memory>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/open_rows.h"

namespace twogrid {

class PressureSolver {
 public:
  /// Collective. dirichlet faces are known by their coefficient: a boundary face with c > 0 couples the cell to a
  /// ghost value of zero, one with c = 0 is closed (wall, inlet).
  /// halo[d]: width of the caller's arrays' halo, at least 1; 0 where one cell lies between closed sides in d (y or z).
  /// Conductances and phi on own cells and that halo are used where they are, and so is a right-hand side on own cells;
  /// arrays on other boxes are copied.
  /// open: parts of the rows of own cells beyond which no cell will ever have a conductance; null: whole rows.
  PressureSolver(MPI_Comm comm, const FineGrid& grid, const Layout& layout, double rtol, const Int3& halo = {1, 1, 1},
                 const OpenRows* open = nullptr);
  ~PressureSolver();

  /// Relative tolerance in force: the constructor's, or -fluid_pressure_rtol, or -fluid_pressure_ksp_rtol.
  double rtol() const;

  /// Sets the operator. conductance[d](i,j,k), own faces: c A / distance of the face (all factors multiplied in), >= 0;
  /// A periodic face is given once, at index 0. Symmetric by construction. Collective.
  /// singular: no boundary face has c > 0 (phi is defined up to a constant; mean zero is returned).
  /// Used in place: a halo of one is filled, and it must stay as it is for the solves.
  void set_operator(FaceField<FineGrid>& conductance, bool singular);
  void set_operator(const FaceField<FineGrid>& conductance, bool singular);
  /// A typical conductance; the range of single precision is laid about it. 0, or not set: that of the next operator.
  double typical_conductance() const;
  void set_typical_conductance(double conductance);

  /// Solves  sum over faces of conductance (phi_neighbour - phi_cell) = b  for own cells; b is an integral over the
  /// cell. Collective. Returns the number of iterations. Throws std::runtime_error with a sentence on all ranks when it
  /// doesn't converge.
  ///
  /// phi: on entry the first guess, on return the solution; own cells only (what is in its halo is no result). Cells
  /// without any open face must have b = 0 and keep the first guess. b used in place is changed.
  ///
  /// Stops at |b - A phi|_2 <= max(rtol |b|_2, atol), or where rounding alone leaves more than that: at 4 machine
  /// epsilons of |b|_2 + |diag(A) phi|_2. A target below 1e-8 |b|_2 is checked on b - A phi itself, not on the
  /// recurrence's residual.
  ///
  /// Singular: the sum of b must be within 1e-6 of the sum of |b| or, over the square root of the number of cells,
  /// within atol; it is spread out evenly. So give an atol wherever b may be round-off alone.
  int solve(CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol = 0);
  int solve(const CellField<FineGrid>& b, CellField<FineGrid>& phi, double atol = 0);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace twogrid
