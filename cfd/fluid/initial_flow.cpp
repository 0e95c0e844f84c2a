#include "cfd/fluid/initial_flow.h"

#include <cmath>

namespace twogrid {

namespace {

/// Adds u = U sin(kx x) cos(ky y), v = -U kx/ky cos(kx x) sin(ky y), one wavelength over the domain's x and y.
void add_vortex(const FluidDomain& domain, double U, FaceField<FineGrid>& u) {
  const Axis &x = domain.grid.axis[0], &y = domain.grid.axis[1];
  const double kx = 2 * std::acos(-1.0) / x.length(), ky = 2 * std::acos(-1.0) / y.length();
  for_each(domain.faces[0], [&](int i, int j, int k) {
    u[0](i, j, k) += U * std::sin(kx * (x.node(i) - x.lo())) * std::cos(ky * (y.centre(j) - y.lo()));
  });
  for_each(domain.faces[1], [&](int i, int j, int k) {
    u[1](i, j, k) -= U * kx / ky * std::cos(kx * (x.centre(i) - x.lo())) * std::sin(ky * (y.node(j) - y.lo()));
  });
}

}  // namespace

void set_initial_velocity(const FluidDomain& domain, const FluidSettings& settings, FaceField<FineGrid>& u) {
  for (int d = 0; d < 3; ++d) u[d].fill(domain.solved[d] ? settings.initial_velocity[d] : 0.0);
  if (settings.initial_vortex != 0) add_vortex(domain, settings.initial_vortex, u);
}

double initial_pressure(const FluidSettings& settings) {
  double first = 0;
  bool any = false;
  for (const auto& side : settings.side)
    for (const BoundaryCondition& c : side) {
      if (c.kind != BoundaryKind::kPressure) continue;
      if (any && c.pressure != first) return 0;
      first = c.pressure, any = true;
    }
  return first;
}

}  // namespace twogrid
