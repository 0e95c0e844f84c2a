// What bodies leave open of the domain's sides.
#pragma once

#include <mpi.h>

#include <array>
#include <vector>

#include "cfd/fluid/fluid.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

/// Open area (m2) of each condition of each side, by whole faces as patches take them; nothing without bodies.
/// Collective.
std::array<std::vector<double>, 6> open_areas(MPI_Comm comm, const FluidSettings& settings, const Fluid& fluid);

}  // namespace twogrid
