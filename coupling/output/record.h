// What the output file keeps of the run that writes it, and of its grids (output.h has the layout).
#pragma once

#include <mpi.h>

#include <string>

#include "coupling/output/output.h"
#include "coupling/two_grid/particle_grid.h"

namespace twogrid {

class GrowingFile;

/// The time, as it is written there.
std::string now();
/// Upper bound of what write_record() adds to a new file, bytes. Local.
double bytes_of_record(const Record& record, const Fluid& fluid);
/// /record, /grid and /particle_grid. id: of the run. Collective.
void write_record(GrowingFile& file, MPI_Comm comm, const Settings& settings, const Fluid& fluid,
                  const ParticleGrid& coarse, const Record& record, const std::string& id);
/// /record/leg_N: the run has gone on, in this file, from a checkpoint of that step. Collective.
void write_leg(GrowingFile& file, MPI_Comm comm, const Record& record, int leg, long step);

}  // namespace twogrid
