// The surfaces as the cut cells have them, to be drawn: of each cell the line in which its open faces end. Neighbours meet
// along it, so that a surface has no gaps.
#pragma once

#include "cfd/bodies/cut_faces.h"

namespace twogrid {

/// Fills the outlines of space.surface. alpha: cleaned, on the faces of LocalGrid.
void outline_walls(const LocalGrid& grid, const CutFaces& faces, const FaceField<FineGrid>& alpha, OpenSpace& space);

}  // namespace twogrid
