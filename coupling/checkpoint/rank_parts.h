// How the box, the fluid's cells and the particles were shared out over the ranks when a checkpoint was written. As many
// ranks that go on with the same shares go on with the same sums, to the last bit.
#pragma once

#include <array>
#include <vector>

#include "cfd/grid/box.h"

namespace twogrid {

struct RankParts {
  Int3 bricks{0, 0, 0};                        ///< of the particles, in each direction; 0: not known
  bool equal = true;                           ///< whether these are equal parts of the box
  std::array<std::vector<double>, 3> borders;  ///< of the bricks: shares of the box, from 0 to 1
  std::array<std::vector<int>, 3> cuts;        ///< of the fluid's cells (Layout)
  std::vector<Int3> fluid_brick;               ///< of each rank
  bool ordered = false;                        ///< whether tags are known:
  std::vector<int> tags;                       ///< of this rank's particles, in their order in memory

  bool known() const { return bricks[0] > 0; }
};

}  // namespace twogrid
