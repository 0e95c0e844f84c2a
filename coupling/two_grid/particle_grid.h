// The particle grid: the grid through which the fluid sees the particles. Its cells, called nodes here to tell them
// from the fluid's cells, are blocks of ratio[0] x ratio[1] x ratio[2] fine cells.
#pragma once

#include "cfd/grid/field.h"
#include "cfd/grid/grid.h"
#include "cfd/grid/layout.h"

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
  double largest_volume() const;  ///< of a node (m3)
  double smallest_width() const;  ///< mean width of a node, directions of one node left out (m)
};

/// The bricks of the fluid's layout in nodes. Throws std::invalid_argument when a cut splits a node.
Layout node_layout(const Layout& fine, const ParticleGrid& nodes);

}  // namespace twogrid
