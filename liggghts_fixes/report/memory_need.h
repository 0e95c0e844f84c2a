// What the fluid and the coupling will need, before anything is allocated, against what the machines have.
#pragma once

#include <mpi.h>

#include <string>

#include "coupling/settings.h"

namespace twogrid {

/// Bytes on all ranks together, for bricks of the fluid's cells: fields, multigrid, coupling and means (fluid_solver.h
/// and averages.h list the arrays). Particles and their neighbour lists are LIGGGHTS' affair. bodies: of the fluid, number.
double bytes_needed(const Settings& settings, const Int3& bricks, std::size_t bodies);

/// Bytes that processes of this machine may still have: of the machine, of a batch job's share, of the process' limit.
double bytes_free();

/// "230 MB", "9.1 TB".
std::string bytes_text(double bytes);

/// Throws std::invalid_argument, on all ranks, where the ranks of a machine would need more than it has, or the cells
/// are more than can be numbered. Returns a line for the user. Collective.
std::string check_memory(MPI_Comm comm, const Settings& settings, const Int3& bricks, double most_cells,
                         std::size_t bodies);

}  // namespace twogrid
