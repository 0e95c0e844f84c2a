// The fluid's properties: numbers, or fields where a model makes them so.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/grid/property.h"

namespace twogrid {

struct FluidProperties {
  Property viscosity;  ///< mu, Pa s
};

/// After models have set properties (fluid_model.h): what varies gets its halo, and beyond the domain's sides the value
/// of the cell at the side; the state gets the largest viscosity. Throws std::runtime_error, on all ranks, where a
/// viscosity is not above zero. Collective.
void complete(const FluidDomain& domain, FluidState& state, FluidProperties& properties);

}  // namespace twogrid
