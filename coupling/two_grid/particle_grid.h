// The particle grid: the grid through which the fluid sees the particles. Its cells, called nodes here to tell them
// from the fluid's cells, are blocks of ratio[0] x ratio[1] x ratio[2] fine cells.
#pragma once

#include <mpi.h>

#include <memory>

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"

namespace twogrid {

class Fluid;
class OpenNodes;

struct ParticleGrid : Grid {
  Int3 ratio{1, 1, 1};  ///< fine cells per node in each direction; {1,1,1}: nodes are the fine cells

  ParticleGrid() = default;
  /// Throws std::invalid_argument with a sentence when a ratio is below 1 or doesn't divide the number of fine cells.
  ParticleGrid(const FineGrid& fine, const Int3& ratio);

  /// The fine cells of one node.
  Box block(int i, int j, int k) const {
    return {{i * ratio[0], j * ratio[1], k * ratio[2]}, {(i + 1) * ratio[0], (j + 1) * ratio[1], (k + 1) * ratio[2]}};
  }
  /// From now on own nodes are what the fluid's bodies leave of them (open_nodes.h). search: nodes around a closed one
  /// among which an open one is looked for. Collective.
  void take_open_part(MPI_Comm comm, const Fluid& fluid, const Int3& search);
  /// Null: all is open.
  const OpenNodes* open_nodes() const { return open_.get(); }
  /// Volume whose solids an own node counts (m3): where bodies stand that of its family's open parts, 0 of nodes that are
  /// closed or no master.
  double volume(int i, int j, int k) const { return volume_ ? (*volume_)(i, j, k) : Grid::volume(i, j, k); }
  /// Volume whose mean an own node shows (m3): that of its family, for all members.
  double shown_volume(int i, int j, int k) const;
  /// What a volume is of a node's; nothing where that is 0.
  double share_of(double part, int i, int j, int k) const {
    const double whole = volume(i, j, k);
    return whole > 0 ? part / whole : 0.0;
  }
  double domain_volume(MPI_Comm comm) const;  ///< m3, open part. Collective
  double largest_volume() const;              ///< of a node (m3), whole
  double smallest_width() const;              ///< mean width of a node, directions of one node left out (m)

 private:
  std::shared_ptr<const OpenNodes> open_;
  const Array3<double>* volume_ = nullptr;  // its
};

/// The bricks of the fluid's layout in nodes. Throws std::invalid_argument when a cut splits a node.
Layout node_layout(const Layout& fine, const ParticleGrid& nodes);

}  // namespace twogrid
