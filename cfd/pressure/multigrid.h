// One symmetric V-cycle of a geometric multigrid for  A x = b,  (A x)_c = sum over faces g_f (x_c - x_nb),  g_f >= 0,
// on a tensor-product grid in bricks. A preconditioner for conjugate gradients: it is a fixed symmetric positive
// operator (semi-definite where no boundary face has g_f > 0).
//
// Coarsening. Along each direction neighbouring cells of one brick are merged in pairs where their centres are close:
// up to kStretch times the smallest distance in any direction, more only as far as is needed to shrink the level. So
// thin and stretched grids approach cubic cells first (semi-coarsening; Mulder 1989), odd sizes leave a cell alone, and
// the coarse grid is a tensor product in bricks again. Only the geometry decides: the hierarchy is made once.
// Coarse conductances. Along a fine line the resistances between the centres of two neighbouring coarse cells are in
// series (half of the face inside each pair, and the face between), and parallel lines add up.
// Prolongation. In every direction linear between the two coarse centres in terms of that resistance, so that the flux
// is continuous where coefficients jump. Restriction is its transpose.
// Few cells a rank. A level of at most kGather cells, and one that bricks can't make smaller (each has a cell left), is
// gathered on every rank, and a multigrid of its own goes on there without messages, merging across bricks.
// Smoother. Red-black Gauss-Seidel: red, black before; black, red after the coarse correction.
#pragma once

#include <mpi.h>

#include <array>
#include <memory>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/open_rows.h"

namespace twogrid {

template <class T>
struct MultigridLevel;

template <class T>
class Multigrid {
 public:
  /// Cells are merged up to this multiple of the smallest distance between centres.
  static constexpr double kStretch = 1.7;
  /// A level has at most about this share of the cells of the finer one.
  static constexpr double kShrink = 0.8;
  /// A level of at most so many cells on all ranks is solved directly.
  static constexpr int kDirect = 100;
  /// A level of at most so many cells on all of several ranks is gathered on each of them.
  static constexpr int kGather = 1000;

  /// All ranks give the same arguments. halo[d]: 1, or 0 where one cell lies between closed sides in d (y or z): no
  /// memory is held beyond them. open: parts of the rows of own cells beyond which no cell will ever have a conductance;
  /// null: whole rows.
  Multigrid(MPI_Comm comm, const Grid& grid, const Layout& layout, const Int3& halo = {1, 1, 1},
            const OpenRows* open = nullptr);
  ~Multigrid();

  /// g[d](i,j,k): of the low face of cell (i,j,k) in direction d; on own cells and a halo of at least one, the high
  /// faces of own cells included (brought from the neighbour, or the boundary's). All g are multiplied by scale, which
  /// may bring them into T's range. Collective.
  void set_operator(const std::array<const Array3<double>*, 3>& g, bool singular, double scale = 1);
  void set_operator(const std::array<Array3<double>, 3>& g, bool singular, double scale = 1) {
    set_operator(std::array<const Array3<double>*, 3>{&g[0], &g[1], &g[2]}, singular, scale);
  }

  /// Right-hand side, to be filled on own cells, and after cycle() the approximate solution there.
  Array3<T>& b();
  Array3<T>& x();
  /// x = B b. Cells without any open face have no equation: b is zero there, and x stays so. Collective.
  void cycle();

  int levels() const;

 private:
  using Level = MultigridLevel<T>;
  class Coarsest;
  class Gathered;
  void cycle(std::size_t l);
  static void coefficients(Level& fine, Level& coarse);

  std::vector<Level> levels_;
  std::unique_ptr<Coarsest> coarsest_;  // one of these two solves the last level
  std::unique_ptr<Gathered> gathered_;
};

}  // namespace twogrid
