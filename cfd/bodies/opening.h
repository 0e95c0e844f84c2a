// The narrowest opening between walls.
#pragma once

#include "cfd/bodies/cut_edges.h"
#include "cfd/bodies/fluid_vertices.h"

namespace twogrid {

/// In cells, along the grid's lines through vertices, where walls stand roughly across them; 0: there is none. One of the
/// two walls may be a side of the domain. Collective.
double narrowest_opening(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges,
                         const FluidVertices& vertices);

}  // namespace twogrid
