// What the cutting has found, summed over bodies and ranks.
#pragma once

#include "cfd/bodies/cut_grid.h"
#include "cfd/bodies/fluid_vertices.h"

namespace twogrid {

/// Areas, volumes and numbers of cells; the rest of the report is left as it is. Collective.
void sum_up(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges, const FluidVertices& vertices,
            const OpenSpace& space, CutReport& report);

}  // namespace twogrid
