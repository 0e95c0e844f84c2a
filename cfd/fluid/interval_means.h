// Means of u and of grad p over a coupling interval, as the steps add up.
#pragma once

#include "cfd/fluid/domain.h"
#include "cfd/fluid/fluid_state.h"

namespace twogrid {

class IntervalMeans {
 public:
  explicit IntervalMeans(const FluidDomain& domain) : domain_(domain) {}

  bool keep_pressure_gradient = false;  ///< the mean of grad p is wanted

  void begin(FluidState& state) const;
  /// Adds the new state's share of the interval.
  void add(double share, FluidState& state) const;

 private:
  void add_rows(double share, FluidState& state) const;
  template <int d>
  void add_gradient(double share, FluidState& state) const;

  const FluidDomain& domain_;
};

}  // namespace twogrid
