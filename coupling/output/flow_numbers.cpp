#include "coupling/output/flow_numbers.h"

#include "cfd/parallel/ranks.h"
#include "cfd/parallel/reduction.h"

namespace twogrid {

FlowNumbers flow_numbers(MPI_Comm comm, const Fluid& fluid, const Particles& particles, const Vec3& up,
                         double pressure_drop) {
  const FineGrid& grid = fluid.grid();
  double to[3];
  for (int d = 0; d < 3; ++d) to[d] = grid.axis[d].periodic() ? 0 : up[d];
  double solids = 0, height = 0, solids_energy = 0, open = 0, fluid_energy = 0;
  for (int i = 0; i < particles.n; ++i) {
    if (!particles.takes_part(i)) continue;
    const double volume = sphere_volume(particles.radius[i]);
    const double *x = particles.x[i], *v = particles.v[i];
    solids += volume;
    solids_energy += 0.5 * volume * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    height += volume * (to[0] * x[0] + to[1] * x[1] + to[2] * x[2]);
  }
  const auto& u = fluid.velocity();
  const OpenShares* const shares = fluid.open_shares();
  const Box own = fluid.layout().cells(rank_of(comm));
  for (int k = own.lo[2]; k < own.hi[2]; ++k)
    for (int j = own.lo[1]; j < own.hi[1]; ++j) {
      const double area = grid.axis[1].width(j) * grid.axis[2].width(k);
      const double *low[3], *high[3];
      for (int d = 0; d < 3; ++d) low[d] = u[d].data() + u[d].index(own.lo[0], j, k), high[d] = low[d] + u[d].stride(d);
      const double* const theta = shares ? shares->theta().data() + shares->theta().index(own.lo[0], j, k) : nullptr;
      for (int i = 0; i < own.size(0); ++i) {
        const double volume = area * grid.axis[0].width(own.lo[0] + i) * (theta ? theta[i] : 1);
        double square = 0;
        for (int d = 0; d < 3; ++d) {
          const double centre = 0.5 * (low[d][i] + high[d][i]);
          square += centre * centre;
        }
        open += volume, fluid_energy += 0.5 * volume * square;
      }
    }
  Reduction::over_ranks(comm, {}, {&solids, &height, &solids_energy, &open, &fluid_energy});
  FlowNumbers n{};
  n[kFlowPressureDrop] = pressure_drop;
  if (solids > 0) n[kFlowSolidsHeight] = height / solids, n[kFlowSolidsEnergy] = solids_energy / solids;
  n[kFlowFluidEnergy] = fluid_energy / open;
  return n;
}

}  // namespace twogrid
