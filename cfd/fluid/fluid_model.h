// A part of the fluid's physics beside mass and momentum, in a file of its own: an eddy viscosity, a transported scalar.
// It is called by the step at the places below, on all ranks; fields that it hands from step to step belong to the
// state (FluidSolver::add_field()), where checks by half the step and checkpoints find them.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid/properties.h"
#include "cfd/fluid/time_step.h"

namespace twogrid {

class FluidModel {
 public:
  virtual ~FluidModel() = default;
  /// Between extrapolation and prediction. It may let properties vary (Property::vary on the domain's local box) and then
  /// sets their values, above zero, in own cells: mu of the momentum balance at t^{n+1} from the state at t^n and u~.
  virtual void properties(const FluidDomain&, const FluidState&, const FaceField<FineGrid>& /*u_tilde*/,
                          FluidProperties&) {}
  /// After a step: the state is that of t^{n+1}. Face by face eps_f u is the flux, and state.rate.at() the d(eps)/dt - q,
  /// with which discrete continuity of this step holds; eps[1] and eps[2] are the levels before.
  virtual void step(const FluidDomain&, const Step&, FluidState&) {}
};

}  // namespace twogrid
