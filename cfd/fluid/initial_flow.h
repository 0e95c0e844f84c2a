// The velocity with which a run starts.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

/// The settings' uniform velocity and vortices; halo, sides and continuity are left to the caller.
void set_initial_velocity(const FluidDomain& domain, const FluidSettings& settings, FaceField<FineGrid>& u);

}  // namespace twogrid
