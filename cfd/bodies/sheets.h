// Sheets: surfaces without a thickness in the middle of the fluid, as baffles and draft tubes. A face is closed where the
// way between the centres of its two cells meets one: steps of whole faces, through which nothing leaks, and friction on
// both sides at the surface's own distance (wall_links.h). The way that the fluid has is right to half a cell.
#pragma once

#include "cfd/bodies/local_grid.h"
#include "cfd/bodies/surfaces.h"

namespace twogrid {

/// Closes faces (alpha = 0, on the faces of the grid) and marks the cells beside them, of the grid's cells; the number of
/// faces on all ranks. Throws std::invalid_argument where a sheet closes none. Collective.
long long close_sheets(const LocalGrid& grid, const Surfaces& sheets, FaceField<FineGrid>& alpha, Array3<char>& beside);

}  // namespace twogrid
