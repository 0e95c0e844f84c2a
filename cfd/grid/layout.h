// Which rank owns which cells and faces: the tensor product of cuts in each direction.
#pragma once

#include <array>
#include <vector>

#include "cfd/grid/box.h"
#include "cfd/grid/grid.h"

namespace twogrid {

/// Bricks of cells. Rank of brick (a,b,c) is a + px (b + py c) unless an order is given. A rank may own no cell.
class Layout {
 public:
  Layout() = default;
  /// cuts[d]: p_d + 1 ascending indices from 0 to n_d (repeats allowed: an empty brick).
  /// brick_of_rank: coordinates of every rank's brick; empty for the default order.
  Layout(const Grid& grid, std::array<std::vector<int>, 3> cuts, std::vector<Int3> brick_of_rank = {});

  int ranks() const { return int(bricks_.size()); }
  /// An empty brick is empty in all directions: no row or plane of it has a length.
  Box cells(int rank) const;
  /// Faces normal to d owned by the rank; the last non-empty brick of a direction that is not periodic owns face n too.
  Box faces(int d, int rank) const;
  std::vector<Box> all_cells() const;
  std::vector<Box> all_faces(int d) const;
  const std::array<std::vector<int>, 3>& cuts() const { return cuts_; }
  const Int3& brick(int rank) const { return bricks_[rank]; }
  Int3 extent() const { return n_; }
  std::array<bool, 3> periodic() const { return periodic_; }
  /// The same bricks on a grid whose cells are blocks of ratio cells of this one. The cuts must be multiples of ratio.
  Layout coarsened(const Grid& coarse, const Int3& ratio) const;

 private:
  Int3 n_{0, 0, 0};
  std::array<bool, 3> periodic_{false, false, false};
  std::array<std::vector<int>, 3> cuts_;
  std::vector<Int3> bricks_;
};

/// Cuts of n cells into p parts at the multiples of `block` nearest to the given positions (p - 1 fractions of the
/// length, e.g. the borders of the particle decomposition). Ascending; parts may be empty.
std::vector<int> cuts_near(const Axis& axis, int p, int block, const std::vector<double>& inner_positions);

/// Equal cuts in multiples of block.
std::vector<int> cuts_even(const Axis& axis, int p, int block = 1);

}  // namespace twogrid
