// Bodies that the grid can't hold, in sentences: std::invalid_argument on all ranks.
#pragma once

#include <string>
#include <vector>

#include "cfd/bodies/cut_edges.h"
#include "cfd/bodies/fluid_vertices.h"

namespace twogrid {

/// Bodies that the grid's edges don't meet, surfaces with fluid on both sides, bodies with no vertex inside. Returns the
/// number of edges that are crossed twice or more. Collective.
long long refuse_unresolved(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges,
                            const FluidVertices& vertices);
/// Inlets and outlets without an open face. alpha: of own faces. Collective.
void refuse_covered(const LocalGrid& grid, const FaceField<FineGrid>& alpha);

}  // namespace twogrid
