#include "liggghts_fixes/liggghts/balance.h"

#include <atom.h>
#include <comm.h>
#include <domain.h>
#include <fix.h>
#include <lammps.h>
#include <modify.h>
#include <mpi.h>
#include <neighbor.h>
#include <update.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "liggghts_fixes/liggghts/even_borders.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr int kBins = 1024;

}  // namespace

/// Fixes that keep something of the ranks' parts of the box, or may: then they stay as they are.
bool Balance::can_be_moved() const {
  static const char* const harmless[] = {"twogrid",
                                         "nve/",
                                         "gravity",
                                         "wall/gran",
                                         "freeze",
                                         "property/",
                                         "contacthistory",
                                         "contactproperty/",
                                         "particletemplate/",
                                         "particledistribution/",
                                         "ave/time",
                                         "ave/atom",
                                         "print",
                                         "check/timestep"};
  const Modify& modify = *lammps_.modify;
  for (int f = 0; f < modify.nfix; ++f)
    if (std::none_of(std::begin(harmless), std::end(harmless), [&](const char* style) {
          return std::strncmp(modify.fix[f]->style, style, std::strlen(style)) == 0;
        }))
      return false;
  return true;
}

double Balance::find_fullest() const {
  long long most = lammps_.atom->nlocal, all = most;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_LONG_LONG, MPI_MAX, lammps_.world);
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_LONG_LONG, MPI_SUM, lammps_.world);
  return all > 0 ? double(most) * lammps_.comm->nprocs / double(all) : 1.0;
}

bool Balance::move_borders() {
  const long long step = (long long)(lammps_.update->ntimestep);
  if (lammps_.comm->nprocs == 1 || (!moving_ && step < next_) || !can_be_moved()) return false;
  next_ = (step / kEvery + 1) * kEvery;
  fullest_ = find_fullest();
  moving_ = false;
  if (fullest_ <= kTolerated) return false;

  Comm& comm = *lammps_.comm;
  Domain& domain = *lammps_.domain;
  std::vector<long long> count(3 * kBins);
  for (int i = 0; i < lammps_.atom->nlocal; ++i)
    for (int d = 0; d < 3; ++d) {
      const double s = (lammps_.atom->x[i][d] - domain.boxlo[d]) / domain.prd[d];
      ++count[d * kBins + int(std::min(std::max(0.0, s * kBins), kBins - 1.0))];  // not a number: in the first
    }
  MPI_Allreduce(MPI_IN_PLACE, count.data(), int(count.size()), MPI_LONG_LONG, MPI_SUM, lammps_.world);
  double* const split[3] = {comm.xsplit, comm.ysplit, comm.zsplit};
  double moved = 0;
  for (int d = 0; d < 3; ++d) {
    const int parts = comm.procgrid[d];
    const double least = lammps_.neighbor->cutneighmax / domain.prd[d];
    if (parts == 1 || parts * least > 1) continue;
    const std::vector<double> old(split[d], split[d] + parts + 1);
    const std::vector<double> border =
        even_borders({count.begin() + d * kBins, count.begin() + (d + 1) * kBins}, old, least);
    for (int i = 1; i < parts; ++i) moved = std::max(moved, std::abs(border[i] - old[i]) * parts);
    std::copy(border.begin(), border.end(), split[d]);
  }
  if (moved < 1e-3) return false;  // there already: no product of cuts does better
  moving_ = true;
  comm.uniform = 0;
  domain.set_local_box();
  comm.setup();
  if (lammps_.neighbor->style) lammps_.neighbor->setup_bins();
  return true;
}

}  // namespace twogrid
