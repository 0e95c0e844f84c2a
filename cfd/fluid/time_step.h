// The fluid's step: how long it may be, and its backward differences.
#pragma once

#include <vector>

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

/// A time step and its BDF2 weights.
struct Step {
  double dt, r, a0, a1, a2;
  double s1 = 0, s2 = 0;  ///< u~ += s1 (u^n - u^{n-1}) - s2 (u^{n-1} - u^{n-2}); central convection
  bool implicit_viscosity = false;
};

class TimeStep {
 public:
  /// Most fluid steps of an interval.
  static constexpr int kMostSteps = 10000;

  TimeStep(FluidDomain& domain, const FluidSettings& settings);

  /// The next step; left: of the interval. Throws std::runtime_error, on all ranks, when the interval would need more
  /// than kMostSteps. Collective.
  Step choose(FluidState& state, double left, double interval);
  /// A shorter one after `step` has turned out to have the Courant number cfl, above the limit.
  Step shortened(FluidState& state, const Step& step, double cfl, double left, double interval);
  /// Sum over directions of the larger |u| of a cell's two faces by its width: largest of all cells, 1/s; infinite
  /// where a velocity is not finite. Collective.
  double courant_rate(const FaceField<FineGrid>& u) const;

 private:
  double allowed_dt(FluidState& state, double left, double interval);
  double largest_viscous_step(const FluidState& state) const;
  Step formula(const FluidState& state, double dt) const;
  void refuse_steps_below(double limit, double interval) const;
  void courant_rows(const FaceField<FineGrid>& u, double& rate, double& finite) const;

  FluidDomain& domain_;
  const FluidSettings& settings_;
  bool implicit_viscosity_ = false;  // of the step chosen last
  mutable std::vector<double> row_most_, row_sum_;
};

}  // namespace twogrid
