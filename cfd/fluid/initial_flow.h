// The velocity and the pressure with which a run starts.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

/// The settings' uniform velocity and vortices; halo, sides and continuity are left to the caller.
void set_initial_velocity(const FluidDomain& domain, const FluidSettings& settings, FaceField<FineGrid>& u);

/// The outlets' pressure, where all have the same (Pa): gas at rest under it stays so from the first step on; else 0.
double initial_pressure(const FluidSettings& settings);

}  // namespace twogrid
