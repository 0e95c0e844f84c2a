// Which rank owns which cells of the fluid, when particles are shared out by someone else.
//
// The fluid may lie where each rank's particles are, so that little has to be carried between the two; or in bricks of
// its own: long rows along x, which cost less a cell, and small faces. The cheapest is taken, by a model in units of
// the work on one cell in a fluid step (counted: instructions of the common case on 1 to 8 ranks).
#pragma once

#include <vector>

#include "cfd/grid/layout.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

/// Costs in cells' work. Of a rank, in a fluid step.
struct LayoutCost {
  static constexpr double kRow = 8;      ///< a row's beginning
  static constexpr double kHalo = 1.5;   ///< a cell in the face of another rank's brick
  static constexpr double kPeer = 300;   ///< another rank beside a face: messages
  static constexpr double kMoved = 0.3;  ///< a node that is carried between the rank's particles and another rank
};

/// Cost of the most loaded rank. window[r]: nodes that the particles of rank r touch (on the particle grid).
double layout_cost(const Grid& grid, const Int3& ratio, const Layout& layout, const std::vector<Box>& window);

/// follow: bricks where the particles are. It is kept unless another is cheaper by more than a tenth. All ranks give
/// the same arguments and get the same layout.
Layout choose_fluid_layout(const Grid& grid, const Int3& ratio, const Layout& follow, const std::vector<Box>& window);

/// px x py x pz equal bricks, cut between particle cells.
Layout equal_bricks(const Grid& grid, const Int3& ratio, const Int3& bricks);

}  // namespace twogrid
