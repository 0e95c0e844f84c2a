// Which faces of a side belong to a patch, and what area they have: one copy, for the solver, the checks and the
// report.
#pragma once

#include "cfd/fluid_settings.h"

namespace twogrid {

/// Whether the centre (m) of a face of the side belongs to the patch. Faces are taken whole.
bool covers(const PatchShape& shape, int side, const Vec3& centre);

struct PatchSize {
  double drawn = -1;  ///< area of the shape (m2); negative: not known (a region that is not measured)
  double faces = 0;   ///< area of the fine faces that the shape covers (m2)
  double open = 0;    ///< of these, those that no later patch lies on (m2)
};
/// Of every condition of the side, in their order.
std::vector<PatchSize> patch_sizes(const FluidSettings& fluid, int side, const FineGrid& grid);

}  // namespace twogrid
