// A given mean of eps u + eps_s v in a periodic direction: the mean pressure gradient that holds it.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

class PressureSolver;

class FlowRate {
 public:
  FlowRate(const FluidDomain& domain, const FluidSettings& settings) : domain_(domain), settings_(settings) {}

  /// Changes u^{n+1}, phi and G so that the flow rates asked for are met; nothing where none is. conductance, solver:
  /// of the step's projection. Collective.
  void hold(FluidState& state, const Interphase& exchange, const FaceField<FineGrid>& conductance,
            PressureSolver& solver, FaceField<FineGrid>& u_next);

 private:
  const FluidDomain& domain_;
  const FluidSettings& settings_;
  CellField<FineGrid> response_rhs_;  // of the potential that answers a unit mean gradient
};

}  // namespace twogrid
