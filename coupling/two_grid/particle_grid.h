// The particle grid: the grid through which the fluid sees the particles. Its cells, called nodes here to tell them
// from the fluid's cells, are blocks of ratio[0] x ratio[1] x ratio[2] fine cells.
#pragma once

#include <mpi.h>

#include <memory>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"
#include "cfd/measures/open_shares.h"

namespace twogrid {

struct ParticleGrid : Grid {
  Int3 ratio{1, 1, 1};  ///< fine cells per node in each direction; {1,1,1}: nodes are the fine cells

  ParticleGrid() = default;
  /// Throws std::invalid_argument with a sentence when a ratio is below 1 or doesn't divide the number of fine cells.
  ParticleGrid(const FineGrid& fine, const Int3& ratio);

  /// The fine cells of one node.
  Box block(int i, int j, int k) const {
    return {{i * ratio[0], j * ratio[1], k * ratio[2]}, {(i + 1) * ratio[0], (j + 1) * ratio[1], (k + 1) * ratio[2]}};
  }
  /// From now on volumes of own nodes are those of their open parts; open: of the fluid, null: all is open.
  void take_open_part(const OpenShares* open, const FineGrid& fine, const Box& own);
  /// Volume of an own node, its open part (m3); 0 inside a body.
  double volume(int i, int j, int k) const { return open_ ? (*open_)(i, j, k) : Grid::volume(i, j, k); }
  /// What a volume is of a node's; nothing inside a body.
  double share_of(double part, int i, int j, int k) const {
    const double whole = volume(i, j, k);
    return whole > 0 ? part / whole : 0.0;
  }
  /// Partly or wholly closed.
  bool cut(int i, int j, int k) const { return open_ && (*open_)(i, j, k) != Grid::volume(i, j, k); }
  double domain_volume(MPI_Comm comm) const;  ///< m3, open part. Collective
  double largest_volume() const;              ///< of a node (m3), whole
  double smallest_width() const;              ///< mean width of a node, directions of one node left out (m)

 private:
  std::shared_ptr<const Array3<double>> open_;  // of own nodes (m3); null: all is open
};

/// The bricks of the fluid's layout in nodes. Throws std::invalid_argument when a cut splits a node.
Layout node_layout(const Layout& fine, const ParticleGrid& nodes);

}  // namespace twogrid
