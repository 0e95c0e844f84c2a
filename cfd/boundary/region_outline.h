// Extent and area of a shape that is known by asking of points only, on its side of the domain: a region of LIGGGHTS.
#pragma once

#include <array>

#include "cfd/fluid_settings.h"

namespace twogrid {

/// Of a patch by region. shape.boxes tell where points are asked: of each at least some tens across, and more where the shape ends.
RegionOutline measure_region(const PatchShape& shape, int side, const std::array<double, 6>& domain);

/// Of all patches by region that have none yet.
void measure_regions(FluidSettings& fluid, const std::array<double, 6>& domain);

}  // namespace twogrid
