#include "liggghts_fixes/liggghts/box.h"

#include <comm.h>
#include <domain.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>
#include <neighbor.h>

#include <algorithm>
#include <array>
#include <vector>

#include "coupling/two_grid/fluid_layout.h"
#include "liggghts_fixes/report/scene_report.h"
#include "liggghts_fixes/run/command_line.h"
#include "liggghts_fixes/run/petsc_session.h"
#include "liggghts_fixes/script/words.h"

namespace twogrid {

using namespace LAMMPS_NS;

BoxFacts box_facts(LAMMPS& lammps) {
  const Domain* const domain = lammps.domain;
  BoxFacts box;
  for (int d = 0; d < 3; ++d) {
    box.bounds[2 * d] = domain->boxlo[d];
    box.bounds[2 * d + 1] = domain->boxhi[d];
    box.periodic[d] = domain->periodicity[d] != 0;
  }
  return box;
}

void check_box(LAMMPS& lammps, const BoxFacts& made_for, const std::string& id) {
  const BoxFacts now = box_facts(lammps);
  for (int d = 0; d < 3; ++d) {
    const std::string side(1, "xyz"[d]);
    const std::string remedy =
        ": give change_box before the first run of fix " + id + ", or unfix it and define it anew";
    if (now.periodic[d] != made_for.periodic[d])
      refuse("box",
             "direction " + side + (now.periodic[d] ? " periodic, which it was not" : " not periodic, which it was") +
                 " when the fluid's grid was made",
             "the boundary as it was" + remedy);
    if (now.bounds[2 * d] != made_for.bounds[2 * d] || now.bounds[2 * d + 1] != made_for.bounds[2 * d + 1])
      refuse("box", side + " from " + text(now.bounds[2 * d]) + " to " + text(now.bounds[2 * d + 1]) + " m",
             text(made_for.bounds[2 * d]) + " to " + text(made_for.bounds[2 * d + 1]) +
                 ", for which the fluid's grid was made" + remedy);
  }
}

Layout fluid_layout(LAMMPS& lammps, const FineGrid& grid, const Int3& ratio) {
  const Comm* const comm = lammps.comm;
  const Domain* const domain = lammps.domain;
  if (const auto given = fluid_bricks_option(comm->nprocs)) return equal_bricks(grid, ratio, *given);
  const double* split[3] = {comm->xsplit, comm->ysplit, comm->zsplit};
  std::array<std::vector<double>, 3> borders;
  std::array<std::vector<int>, 3> cuts;
  for (int d = 0; d < 3; ++d) {
    for (int i = 0; i <= comm->procgrid[d]; ++i) borders[d].push_back(domain->boxlo[d] + split[d][i] * domain->prd[d]);
    const std::vector<double> inner(borders[d].begin() + 1, borders[d].end() - 1);
    cuts[d] = cuts_near(grid.axis[d], comm->procgrid[d], ratio[d], inner);
  }
  const ParticleGrid nodes(grid, ratio);
  std::vector<Int3> brick_of_rank(comm->nprocs);
  std::vector<Box> window(comm->nprocs);
  for (int i = 0; i < comm->procgrid[0]; ++i)
    for (int j = 0; j < comm->procgrid[1]; ++j)
      for (int k = 0; k < comm->procgrid[2]; ++k) {
        const int rank = comm->grid2proc[i][j][k];
        const Int3 brick = brick_of_rank[rank] = {i, j, k};
        for (int d = 0; d < 3; ++d) {
          const Axis& a = nodes.axis[d];
          window[rank].lo[d] = std::max(a.find(borders[d][brick[d]]) - 1, 0);
          window[rank].hi[d] = std::min(a.find(borders[d][brick[d] + 1]) + 2, a.n());
        }
      }
  return choose_fluid_layout(grid, ratio, Layout(grid, cuts, brick_of_rank), window);
}

bool prompt_lists(LAMMPS& lammps) {
  const Neighbor* const neighbor = lammps.neighbor;
  return neighbor->every == 1 && neighbor->delay == 0 && neighbor->dist_check;
}

double reach(LAMMPS& lammps) {
  return (prompt_lists(lammps) ? 0.5 : 1.0) * lammps.neighbor->skin;
}

ParticleRegion particle_region(LAMMPS& lammps) {
  ParticleRegion region;
  for (int d = 0; d < 3; ++d) region.lo[d] = lammps.domain->sublo[d], region.hi[d] = lammps.domain->subhi[d];
  region.reach = reach(lammps);
  return region;
}

double choose_skin(LAMMPS& lammps, SceneFacts& facts) {
  const Modify* const modify = lammps.modify;
  for (int f = 0; f < modify->nfix; ++f)
    if (std::string(modify->fix[f]->style).rfind("mesh", 0) == 0) return 0;
  const double d = facts.d_mean;
  // A wide skin may be there for lists that are looked at late.
  if (!(d > 0) || (facts.skin >= kLeastSkin * d && (facts.skin <= kMostSkin * d || !prompt_lists(lammps)))) return 0;
  facts.script_skin = facts.skin;
  facts.skin = 0.5 * (kLeastSkin + kMostSkin) * d;
  lammps.neighbor->skin = facts.skin;
  return facts.skin;
}

}  // namespace twogrid
