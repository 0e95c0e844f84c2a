// Which of the grid's vertices are in the fluid.
#pragma once

#include <string>
#include <vector>

#include "cfd/bodies/connected_parts.h"
#include "cfd/bodies/cut_edges.h"

namespace twogrid {

enum class VertexKind : unsigned char { kSolid, kFluid, kOnSurface };

struct FluidVertices {
  Array3<VertexKind> kind;  ///< own ones and those of the cells around
  /// Own vertices that an uncrossed way joins to a point of fluid_at.
  std::vector<Int3> held;
  std::string told_by;  ///< what told the fluid's parts, in words
  Array3<int> part;     ///< what uncrossed edges join, of all vertices but those on surfaces (-1)
  int parts = 0;
  VertexKind operator()(int i, int j, int k) const { return kind(i, j, k); }
};

/// Throws std::invalid_argument with a sentence, on all ranks, where the fluid's side can't be told. Collective.
FluidVertices find_fluid(const LocalGrid& grid, const Surfaces& surfaces, const CutEdges& edges);

}  // namespace twogrid
