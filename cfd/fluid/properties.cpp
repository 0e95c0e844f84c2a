#include "cfd/fluid/properties.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace twogrid {

void complete(const FluidDomain& domain, FluidState& state, FluidProperties& properties) {
  Property& mu = properties.viscosity;
  if (!mu.varies()) return;
  CellField<FineGrid>& field = mu.vary(domain.local);
  double extremes[2] = {0, 0};  // largest mu and 1/mu
  for_each(domain.own, [&](int i, int j, int k) {
    const double value = field(i, j, k), inverse = value > 0 && std::isfinite(value) ? 1 / value : INFINITY;
    extremes[0] = std::max(extremes[0], value), extremes[1] = std::max(extremes[1], inverse);
  });
  MPI_Allreduce(MPI_IN_PLACE, extremes, 2, MPI_DOUBLE, MPI_MAX, domain.comm);
  if (!std::isfinite(extremes[1])) {
    std::ostringstream text;
    text << "the fluid's viscosity is not above zero and finite in every cell at t = " << state.time
         << " s; wanted: above zero everywhere from the model of viscosity";
    throw std::runtime_error(text.str());
  }
  state.largest_viscosity = extremes[0];
  domain.extend(field);
}

}  // namespace twogrid
