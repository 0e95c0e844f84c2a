// The fluid's properties, and the call by which a model makes them fields.
#pragma once

#include <functional>

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/grid/property.h"

namespace twogrid {

struct FluidProperties {
  Property viscosity;  ///< mu, Pa s
};

/// A model of properties. It may let properties vary (Property::vary on the domain's local box) and then sets their
/// values, above zero, in own cells: mu of the momentum balance at t^{n+1} from the state at t^n and u~. Called on all
/// ranks.
using PropertyModel =
    std::function<void(const FluidDomain&, const FluidState&, const FaceField<FineGrid>& u_tilde, FluidProperties&)>;

/// Calls the model. What varies gets its halo, and beyond the domain's sides the value of the cell at the side; the
/// state gets the largest viscosity. Throws std::runtime_error, on all ranks, where a viscosity is not above zero.
/// Collective.
void update_properties(const FluidDomain& domain, const PropertyModel& model, const FaceField<FineGrid>& u_tilde,
                       FluidState& state, FluidProperties& properties);

}  // namespace twogrid
