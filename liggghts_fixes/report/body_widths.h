// How wide bodies are, and what is open between them: for the choice of grids. Along lines through each body, where surfaces
// cross them: a part between two crossings counts where nothing is much nearer to its middle than its ends, and where it is no
// part of a wedge, that narrows to nothing.
//
//   round (as long across as along, to a factor of 2.5): bodies and channels, whose diameter is D = l^2/(4 r) + r, l the part's
//   length and r the distance of its middle from the surface, which is exact for a cylinder wherever the line goes through
//   flat: plates, and gaps between bodies or a body and a wall that is a side
#pragma once

#include <vector>

#include "cfd/bodies/solid_shape.h"
#include "cfd/grid/grid.h"
#include "liggghts_fixes/script/grid_choice.h"

namespace twogrid {

constexpr int kCellsAcrossGap = 4, kCellsAcrossPlate = 2;

struct BodyMeasures {
  std::vector<WidthAcross> widths;
  std::array<std::vector<double>, 3>
      open_layers;  ///< of the domain's cells: open volume by layers along x, y, z (m3), estimated
};

/// domain: of any cells. walls: sides of the domain that the fluid can't pass. particles: some, which tell what is fluid
/// where a shape doesn't know. Gaps narrower than `grain` (m) are left out.
BodyMeasures measure_bodies(const std::vector<Body>& bodies, const Grid& domain, const std::array<bool, 6>& walls,
                            const std::vector<Vec3>& particles, double grain);

}  // namespace twogrid
