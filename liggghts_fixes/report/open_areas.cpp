#include "liggghts_fixes/report/open_areas.h"

#include "cfd/boundary/patches.h"
#include "cfd/parallel/ranks.h"

namespace twogrid {

std::array<std::vector<double>, 6> open_areas(MPI_Comm comm, const FluidSettings& settings, const Fluid& fluid) {
  std::array<std::vector<double>, 6> areas;
  const OpenShares* const open = fluid.open_shares();
  if (!open) return areas;
  const FineGrid& grid = fluid.grid();
  for (int side = 0; side < 6; ++side) {
    const auto& conditions = settings.side[side];
    const int d = direction(side), e = d == 0 ? 1 : 0, f = d == 2 ? 1 : 2, at = is_high(side) ? grid.axis[d].n() : 0;
    std::vector<double>& sums = areas[side];
    sums.assign(conditions.size(), 0);
    Box own = fluid.layout().faces(d, rank_of(comm));
    const bool has = !grid.axis[d].periodic() && own.lo[d] <= at && at < own.hi[d];
    own.lo[d] = at, own.hi[d] = at + 1;
    Vec3 x;
    x[d] = is_high(side) ? grid.axis[d].hi() : grid.axis[d].lo();
    if (has)
      for_each(own, [&](int i, int j, int k) {
        const Int3 c{i, j, k};
        x[e] = grid.axis[e].centre(c[e]), x[f] = grid.axis[f].centre(c[f]);
        std::size_t top = 0;
        for (std::size_t q = 0; q < conditions.size(); ++q)
          if (covers(conditions[q].shape, side, x)) top = q;
        sums[top] += open->alpha(d, open->theta().index(i, j, k)) * grid.axis[e].width(c[e]) * grid.axis[f].width(c[f]);
      });
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), int(sums.size()), MPI_DOUBLE, MPI_SUM, comm);
  }
  return areas;
}

}  // namespace twogrid
