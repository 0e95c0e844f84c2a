// Figures of the fluid's state: continuity, flows through the sides, pressure drop, momentum.
#pragma once

#include <vector>

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid.h"
#include "cfd/fluid/fluid_state.h"
#include "cfd/fluid_settings.h"

namespace twogrid {

class Monitors {
 public:
  Monitors(const FluidDomain& domain, const FluidSettings& settings)
      : domain_(domain), settings_(settings), row_a_(domain.local.size(0)), row_b_(domain.local.size(0)) {}

  /// Adds the step that led to the state to the interval's report. share: the step's of the interval; inlet_head:
  /// Predictor's; velocity_scale: Projection's. Collective.
  void measure(const FluidState& state, double inlet_head, double velocity_scale, double share,
               FluidReport& report) const;
  /// Relative difference of two states, as FluidReport::step_error. Collective.
  double difference(const FluidState& state, const FluidState& other) const;
  /// As FluidSolver's. Collective.
  Vec3 total_momentum(const FluidState& state) const;
  Vec3 pending_momentum(const FluidState& state) const;

 private:
  void largest_imbalance(const FluidState& state, double& worst, double& displaced) const;

  const FluidDomain& domain_;
  const FluidSettings& settings_;
  mutable std::vector<double> row_a_, row_b_;  // one value a cell of a row
};

}  // namespace twogrid
